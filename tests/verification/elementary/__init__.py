"""Error and cost of the core's elementary functions, beside those of the C library.

    ./build.sh run elementary [--count 1e7]

Errors are counted in units of the last place (ulp) of the exact value, at random arguments and at hard ones:
borders between two ways of computing, both ends of each exponent, and for each exponent the double closest
to a multiple of pi/2. `reference.c` sums Taylor's series in double-double arithmetic. At 10,000 arguments of
each function, and wherever an error is above 0.8 ulp, 60 digits give the error again, and must agree to
1e-9 ulp. The published error is that of 60 digits. Costs: instructions of a call by callgrind, and
processor time, over arguments from 0.01 to 6.

The functions "of two" are those of elementary/vector2.h, for the friction of both cams at once; both columns
of costs hold two values. "small exp" is for arguments up to 0.1; its costs do not depend on the argument.

Then callgrind counts which of the functions the steps of the FMU call (shares.py).
"""
