"""How does a closed loop with the cam become an SSP package that other masters run?

./build.sh run ssp

systems       three examples as systems of FMUs: the cam, a controller, a motor, a load
components    their components with start values
clamp         the spring clamp as a system of FMUs: the cam, a servo, a thermal network
clamp_runs    its package in ecos and libcosim, with and without connections to parameters
package       writes such a system as an SSP package
coupling      the same package, coupled by FMPy
parts         controllers, motor and loads as FMUs of C code, with variables and compilation
hosts         the programs that play a package in a master
outcome       rows of the tables of docs/use-ssp.md
__main__      runs the packages in ecos and libcosim, compares, and writes docs/use-ssp.md
"""
