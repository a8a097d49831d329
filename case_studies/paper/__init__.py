"""The paper on the dual cylindrical cam, reproduced and corrected: writes docs/paper.md and its pictures.

./build.sh run paper

published       published and assumed values
cams            the pairs of cams with the arcs assumed, and their statics
efficiency      efficiency over the lead angles by formula
fmus            the numbers that come from the FMUs
printed         the paper's equations as printed
readings        readings by hand, other friction laws, misalignment
varying         torque with friction that varies with speed and load
fits            laws of friction that come nearest to the published errors
theory, measurements, budget, friction, pictures, text      sections and pictures of the page
__main__        the page
"""
