"""The base of the schemas of design files and study plans."""

from pydantic import BaseModel, ConfigDict


class TomlTable(BaseModel):
    """A table of a file: no other keys than these, and no values of other types."""

    model_config = ConfigDict(extra="forbid", strict=True)
