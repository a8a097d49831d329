"""The cost of a step on other platforms, as ratios to the Linux x86-64 binary in the same run.

    ./build.sh run platforms

One program in C (steps.c), compiled for each platform, loads the FMU's binary of that platform and makes the
same steps. Windows: wine runs the machine code of the x86-64 binary directly, so times are compared.
aarch64: qemu translates the machine code, so instructions are compared. A plugin of qemu
(count_instructions.c) counts them, for x86-64 too. Each program runs twice, with and without the steps of its
blocks; the difference is that of the steps. All platforms must reach the same bits.
"""
