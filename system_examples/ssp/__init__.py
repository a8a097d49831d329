"""How does a closed loop with the cam become an SSP package that other masters run?

./build.sh ssp

systems       the three examples as systems of FMUs: the cam, a controller, a motor, a load
components    their components with start values
package       writes such a system as an SSP package
coupling      the same package, coupled by FMPy
parts         controllers, motor and loads as FMUs of C code, with variables and compilation
__main__      runs the packages in ecos and libcosim, compares, and writes docs/ssp.md
"""
