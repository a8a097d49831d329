"""The solid of a cam as a STEP file in millimetres."""

from pathlib import Path
from typing import Any

from dualcam.common.version import __version__
from dualcam.design.cut.cam_body import CamBody
from dualcam.design.cut.groove_cut import GrooveCut
from dualcam.design.cut.labels import ZERO_LABEL, cut_label
from dualcam.design.cut.solid import cam_solid, require_kernel
from dualcam.errors import DesignError


def write_step(cut: GrooveCut, body: CamBody, path: Path) -> None:
    """Write the solid of the cam. The z axis is the axis of the cam."""
    require_kernel()
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Interface import Interface_Static
    from OCP.Message import Message, Message_Gravity
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    solid = cam_solid(cut, body)
    printers = Message.DefaultMessenger_s().Printers()
    for k in range(1, printers.Length() + 1):  # else the kernel prints statistics
        printers.Value(k).SetTraceLevel(Message_Gravity.Message_Fail)
    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    done = writer.Transfer(solid, STEPControl_StepModelType.STEPControl_AsIs)
    if done == IFSelect_ReturnStatus.IFSelect_RetDone:
        _name(writer.Model(), cut, path)
        done = writer.Write(str(path))
    if done != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise DesignError(f"{path} cannot be written: check folder and rights")


def _name(model: Any, cut: GrooveCut, path: Path) -> None:  # noqa: ANN401
    """The names in the file: what a CAD program shows."""
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.StepBasic import StepBasic_Product
    from OCP.TCollection import TCollection_HAsciiString

    header = APIHeaderSection_MakeHeader(model)
    header.SetName(TCollection_HAsciiString(path.name.encode("ascii", "replace").decode()))
    header.SetAuthorValue(1, TCollection_HAsciiString(""))
    header.SetOrganizationValue(1, TCollection_HAsciiString(""))
    header.SetOriginatingSystem(TCollection_HAsciiString(f"dualcam {__version__}"))
    header.SetDescriptionValue(1, TCollection_HAsciiString(f"{cut_label(cut)}; {ZERO_LABEL}; units mm"))
    for k in range(1, model.NbEntities() + 1):
        product = model.Value(k)
        if isinstance(product, StepBasic_Product):
            name = TCollection_HAsciiString(f"dualcam cam {cut.cam}")
            product.SetName(name)
            product.SetId(name)
