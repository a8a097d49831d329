"""Error and cost of the core's elementary functions, beside those of the C library.

    ./build.sh elementary

Errors are counted in units of the last place (ulp) against the 64-bit mantissa of `long double`. The argument
with the greatest error is computed again with 60 digits, and this error is reported. Costs: instructions of a
call by callgrind, and processor time, over arguments from 0.01 to 6.
"""
