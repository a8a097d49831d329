"""The solid of a cam as a STEP file in millimetres."""

from __future__ import annotations

from pathlib import Path

from dualcam.design.cut.cam_body import CamBody
from dualcam.design.cut.groove_cut import GrooveCut
from dualcam.design.cut.solid import cam_solid, require_kernel
from dualcam.design.statics import DesignError


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
    Interface_Static.SetCVal_s("write.step.product.name", f"cam {cut.cam}")
    done = writer.Transfer(solid, STEPControl_StepModelType.STEPControl_AsIs)
    if done == IFSelect_ReturnStatus.IFSelect_RetDone:
        done = writer.Write(str(path))
    if done != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise DesignError(f"{path} cannot be written: check folder and rights")
