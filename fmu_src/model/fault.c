#include "model/fault.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "platform/attributes.h"

COLD ShortestDecimal shortest_decimal(double value) {
    ShortestDecimal shortest;
    if (fabs(value) < 1e15 && value == floor(value)) { /* "50000" rather than "5e+04" */
        snprintf(shortest.text, sizeof shortest.text, "%.0f", value);
        return shortest;
    }
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(shortest.text, sizeof shortest.text, "%.*g", digits, value);
        if (strtod(shortest.text, NULL) == value) break;
    }
    return shortest;
}
