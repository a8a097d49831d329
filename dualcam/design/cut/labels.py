"""What a workshop must know about a groove, in lines of ASCII for drawings and solids."""

from dualcam.design.cut.groove_cut import GrooveCut

ZERO_LABEL = "angle 0 and z = 0: axis of the pin at theta = 0; the lower flank carries the spring"
AXIS_LABEL = "+z is up: the pin moves up while the spring is loaded"


def cut_label(cut: GrooveCut) -> str:
    """The cam, its grooves and the pin."""
    grooves = "2 grooves half a turn apart" if cut.mechanism.contacts == 2 else "1 groove"
    return (
        f"dualcam: cam {cut.cam} ({'stands still' if cut.cam == 1 else 'turns'}), {grooves},"
        f" {'right' if cut.hand > 0 else 'left'}-handed, radial pin of diameter"
        f" {2e3 * cut.pin_radius:.6g} mm, run-out {1e3 * cut.run_out:.6g} mm"
    )
