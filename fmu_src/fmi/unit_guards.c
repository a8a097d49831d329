#include "fmi/unit_guards.h"

#include <math.h>

#include "model/fault.h"
#include "platform/attributes.h"

typedef enum { ABOVE, BELOW } Side;

typedef struct {
    VariableId variable;
    Side side;
    double limit;            /* a value is strange whose magnitude is above, or which is between 0 and the limit */
    const char *likely;      /* what the value looks like */
    const char *other_unit;  /* its sign, */
    double per_unit;         /* and how many of it make one of the variable's unit */
} UnitGuard;

/* Of one variable the first guard that finds it strange counts. */
static const UnitGuard GUARDS[] = {
#define UNIT_GUARD(model, id, side, limit, likely, other_unit, per_unit)                                               \
    IN_##model({VR_##id, side, limit, likely, other_unit, per_unit}, )
#include "fmi/unit_guard_table.h"
};

enum { GUARD_COUNT = sizeof GUARDS / sizeof GUARDS[0] };

static double value_of(const Instance *instance, VariableId id) {
    return *(const double *)((const char *)&instance->values + VARIABLES[id].offset);
}

static bool is_strange(const UnitGuard *guard, double value) {
    return guard->side == ABOVE ? fabs(value) > guard->limit : value > 0.0 && value < guard->limit;
}

COLD static void warn(const Instance *instance, const UnitGuard *guard, double value) {
    const Variable *variable = &VARIABLES[guard->variable];
    const char *unit = variable->unit == UNIT_ONE ? "" : UNITS[variable->unit].name;
    const char *space = *unit == '\0' ? "" : " ";
    const ShortestDecimal given = shortest_decimal(value), meant = shortest_decimal(value / guard->per_unit);
    instance_warn(instance, "%s = %s%s%s: this looks like %s; %s %s is %s%s%s", variable->name, given.text, space, unit,
                  guard->likely, given.text, guard->other_unit, meant.text, space, unit);
}

void unit_guards_warn(const Instance *instance) {
    int warned = -1; /* the last variable */
    for (int i = 0; i < GUARD_COUNT; i++) {
        const UnitGuard *guard = &GUARDS[i];
        const double value = value_of(instance, guard->variable);
        if ((int)guard->variable == warned || !is_strange(guard, value)) continue;
        warn(instance, guard, value);
        warned = (int)guard->variable;
    }
}
