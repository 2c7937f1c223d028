"""The parts of isolation one by one: channels that do not wait, replies that fit, families of processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.errors import EndRequestError, FmuFileError, RunError, SlaveError
from cosim.fmi2.isolation.channel import Pipes, PolledPipes, ThreadedPipes
from cosim.fmi2.isolation.family import Family
from cosim.fmi2.isolation.protocol import REQUEST, Operation, PackedRows, RowBytes, receive
from cosim.fmi2.isolation.reply import Content, failure, read_content


@pytest.fixture(params=[PolledPipes, ThreadedPipes])
def ends(request: pytest.FixtureRequest) -> Iterator[tuple[Pipes, int, int]]:
    """A channel, and the two descriptors at its other end."""
    if request.param is PolledPipes and sys.platform == "win32":
        pytest.skip("Windows polls no pipes")
    requests, to = os.pipe()
    back, replies = os.pipe()
    channel = request.param(open(to, "wb", buffering=0), open(back, "rb", buffering=0))  # noqa: SIM115
    yield channel, requests, replies
    channel.close()
    for descriptor in (requests, replies):
        try:
            os.close(descriptor)
        except OSError:
            continue


def received(channel: Pipes, size: int) -> bytes:
    whole, buffer = b"", memoryview(bytearray(1000))
    while len(whole) < size:
        try:
            whole += buffer[: channel.receive(buffer)]
        except TimeoutError:
            continue
    return whole


def test_a_channel_carries_all_bytes_both_ways(ends: tuple[Pipes, int, int]) -> None:
    channel, requests, replies = ends
    content = bytes(range(256)) * 40
    channel.send(memoryview(content[:1000]))
    assert os.read(requests, 1000) == content[:1000]
    os.write(replies, content)
    assert received(channel, len(content)) == content


def test_a_channel_does_not_wait_for_what_does_not_come(ends: tuple[Pipes, int, int]) -> None:
    with pytest.raises(TimeoutError):
        ends[0].receive(memoryview(bytearray(10)))


def test_a_channel_whose_other_end_is_closed_has_ended(ends: tuple[Pipes, int, int]) -> None:
    channel, _, replies = ends
    os.close(replies)
    buffer = memoryview(bytearray(10))
    while True:
        try:
            assert channel.receive(buffer) == 0
        except TimeoutError:
            continue
        return


def test_a_channel_that_nobody_reads_does_not_wait() -> None:
    requests, to = os.pipe()
    back, replies = os.pipe()
    channel = PolledPipes(open(to, "wb", buffering=0), open(back, "rb", buffering=0))  # noqa: SIM115
    channel.send(memoryview(bytes(2**20)))  # which fills the pipe
    with pytest.raises(TimeoutError):
        channel.send(memoryview(bytes(2**20)))
    channel.close()
    for descriptor in (requests, replies):
        os.close(descriptor)


def test_a_request_arrives_whole_however_it_is_cut() -> None:
    requests, to = os.pipe()
    data, text = bytes(1000), b'{"name": "plant"}'
    message = REQUEST.pack(7, Operation.STEP, 1, 0, 0.5, 0.1, len(data), len(text)) + data + text
    os.write(to, message[:20])
    child = os.fork() if sys.platform != "win32" else 0
    if child == 0:
        time.sleep(0.01)
        os.write(to, message[20:500])
        time.sleep(0.01)
        os.write(to, message[500:])
        os._exit(0)
    head, numbers, rest = receive(requests)
    os.waitpid(child, 0)
    assert head[:6] == (7, Operation.STEP, 1, 0, 0.5, 0.1)
    assert (bytes(numbers), bytes(rest)) == (data, text)
    os.close(to)
    with pytest.raises(EOFError):
        receive(requests)
    os.close(requests)


@given(st.binary(min_size=64, max_size=64))
def test_rows_arrive_with_the_same_bits(content: bytes) -> None:
    reals = np.frombuffer(content[:32]).reshape(2, 2)
    integers = np.frombuffer(content[32:], np.int32).reshape(2, 4)[:, :3]
    there = [np.zeros((2, 3), np.int32), np.zeros((2, 2)), np.full((2, 1), "", object), np.zeros((2, 0))]
    here = [integers, reals, there[2], there[3]]
    sender, receiver, packed = RowBytes(here), RowBytes(there), PackedRows(there)
    packed.row(1)[:] = sender.take(1)
    receiver.load(packed.row(1))
    receiver.put(0)
    for arrays, row in ((there, 0), (packed.arrays, 1)):
        assert arrays[0][row].tobytes() == integers[1].tobytes()
        assert arrays[1][row].tobytes() == reals[1].tobytes()
    assert not any(packed.row(0))


SAID = {"level": 30, "category": "logAll", "says_why": False, "text": "ready"}
CALL = {"kind": "call", "function": "fmi2DoStep", "status": "fmi2Error", "message": "why"}
NONSENSE = [
    [],
    1,
    "text",
    {"unknown": 1},
    {"texts": "abc"},
    {"texts": [1]},
    {"texts": None},
    {"log": [[30, "a", False, "b"]]},
    {"log": [SAID] * 101},
    {"log": [{**SAID, "level": "30"}]},
    {"log": [{**SAID, "level": 10**400}]},
    {"log": [{**SAID, "level": True}]},
    {"log": [{**SAID, "text": "x" * 1001}]},
    {"log": [{**SAID, "says_why": 1}]},
    {"log": [{**SAID, "more": 1}]},
    {"log": [{"level": 30}]},
    {"error": "text"},
    {"error": {}},
    {"error": {**CALL, "kind": "else"}},
    {"error": {**CALL, "function": ["fmi2DoStep"]}},
    {"error": {**CALL, "message": "x" * 10001}},
    {"error": {"kind": "end", "end": "1.0", "message": ""}},
    {"error": {"kind": "end", "end": None, "message": ""}},
    {"error": {"kind": "refused", "text": "why"}},
    {"error": {"kind": "refused", "text": "why", "file": "yes"}},
]


@pytest.mark.parametrize("content", NONSENSE, ids=range(len(NONSENSE)))
def test_content_that_does_not_fit_is_none(content: object) -> None:
    with pytest.raises(ValueError):  # noqa: PT011
        read_content(json.dumps(content).encode())


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"{",
        b"\xff",
        b"[" * 100000,
        b'{"texts": ["\\ud800"]}',
        b'{"error": {"kind": "end", "end": NaN, "message": ""}}',
        b'{"error": {"kind": "end", "end": 1e999, "message": ""}}',
        b"9" * 5000,
    ],
    ids=range(8),
)
def test_what_is_no_json_is_none(text: bytes) -> None:
    with pytest.raises(ValueError):  # noqa: PT011
        read_content(text)


@given(st.binary() | st.recursive(st.none() | st.text() | st.floats(), lambda inner: st.lists(inner)).map(repr))
def test_nothing_that_is_read_raises_anything_else(text: Any) -> None:
    try:
        read_content(text.encode("utf-8", "replace") if isinstance(text, str) else text)
    except ValueError:
        return


@pytest.mark.parametrize(
    ("error", "kind", "told"),
    [
        (CALL, SlaveError, "plant at t = 2.00 s: fmi2DoStep returned fmi2Error: why"),
        (
            {"kind": "end", "end": 2.5, "message": ""},
            EndRequestError,
            "plant asked to end the simulation at t = 2.50 s",
        ),
        ({"kind": "refused", "text": "a.fmu: no", "file": True}, FmuFileError, "a.fmu: no"),
        ({"kind": "refused", "text": "plant: no", "file": False}, RunError, "plant: no"),
    ],
)
def test_failures_are_raised_as_they_were_there(error: dict[str, Any], kind: type[Exception], told: str) -> None:
    content = read_content(json.dumps({"error": error}).encode())
    raised = failure("plant", 2.0, content)
    assert type(raised) is kind
    assert str(raised) == told


def test_a_failure_without_a_reason_is_a_failure() -> None:
    assert str(failure("plant", 2.0, Content())) == "plant: the FMU's process failed without a reason"


GENERATIONS = """
import os, sys, time
def go_on(depth):
    os.setsid()
    if depth and os.fork() == 0:
        go_on(depth - 1)
    if depth == 0:
        print("ready", flush=True)
    time.sleep(1000)
if os.fork() == 0:
    go_on(2)
time.sleep(1000)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="families are looked up in /proc")
@pytest.mark.parametrize("listed", [True, False], ids=["with lists of children", "without"])
def test_a_family_is_known_and_ended_whatever_sessions_it_is_in(listed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cosim.fmi2.isolation.family.LISTED", listed)
    head = subprocess.Popen([sys.executable, "-c", GENERATIONS], stdout=subprocess.PIPE)
    assert head.stdout is not None
    with head.stdout:
        head.stdout.readline()
    family = Family(head.pid)
    members = family.look()
    assert len(members) == 3
    assert family.held() >= family.shared_out() > 1e6
    head.kill()  # whose descendants are nobody's then
    head.wait()
    assert family.look() == []
    assert family.end(10.0)
    assert not [member for member in members if is_alive(member)]


def is_alive(process: int) -> bool:
    try:
        return "State:\tZ" not in Path(f"/proc/{process}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False
