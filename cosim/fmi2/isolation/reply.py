"""Read what the process of an isolated FMU says beside numbers, and raise what went wrong there.

The process may say anything, as the FMU has its memory: what does not fit the models below is no answer.
"""

from __future__ import annotations

import logging
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from cosim.errors import CosimError, EndRequestError, FmuFileError, RunError, SlaveError

MOST_MESSAGES, LONGEST_MESSAGE, LONGEST_SENTENCE = 100, 1000, 10000

_Message = Annotated[str, Field(max_length=LONGEST_MESSAGE)]


class _Part(BaseModel):
    """Take what is told as it is declared, without conversions, or not at all."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Said(_Part):
    """One message of the FMU, for the log."""

    level: Annotated[int, Field(ge=logging.NOTSET, le=logging.CRITICAL)]
    category: _Message
    says_why: bool
    text: _Message


class CallFailed(_Part):
    """A call that did not return fmi2OK."""

    kind: Literal["call"] = "call"
    function: _Message
    status: _Message
    message: Annotated[str, Field(max_length=LONGEST_SENTENCE)]


class EndAsked(_Part):
    """A step that was discarded as the FMU wants to end the simulation, up to a time [s]."""

    kind: Literal["end"] = "end"
    end: Annotated[float, Field(allow_inf_nan=False)]
    message: Annotated[str, Field(max_length=LONGEST_SENTENCE)]


class Refused(_Part):
    """Anything else, as a whole sentence; `file` tells whether the .fmu file is at fault."""

    kind: Literal["refused"] = "refused"
    text: Annotated[str, Field(max_length=LONGEST_SENTENCE)]
    file: bool


class Content(_Part):
    """All that a reply says beside numbers."""

    error: Annotated[CallFailed | EndAsked | Refused, Field(discriminator="kind")] | None = None
    texts: list[str] = []
    not_kept: dict[str, bool | int | float | str] = {}
    log: Annotated[list[Said], Field(max_length=MOST_MESSAGES)] = []


def read_content(text: bytes) -> Content:
    """Read JSON; ValueError if it is none, or tells anything else."""
    return Content.model_validate_json(text)


def log_messages(name: str, content: Content | None) -> None:
    """Log what an FMU has said, as if it had been here."""
    logger = logging.getLogger(f"cosim.fmi2.{name}")
    for said in content.log if content else ():
        logger.log(said.level, "%s", said.text, extra={"category": said.category, "says_why": said.says_why})


def failure(name: str, time: float, content: Content | None) -> CosimError:
    """Return the exception that an operation at a communication point `time` [s] has failed with."""
    match content and content.error:
        case EndAsked(end=end, message=message):
            return EndRequestError(name, time, message, end)
        case CallFailed(function=function, status=status, message=message):
            return SlaveError(name, time, function, status, message)
        case Refused(text=text, file=file):
            return FmuFileError(text) if file else RunError(text)
        case None:
            return RunError(f"{name}: the FMU's process failed without a reason")
