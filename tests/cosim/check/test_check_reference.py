"""Reference experiments: every layout is read, wrong results are caught, and what is allowed is what was stated."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cosim.check import Comparison, Finding, Group, Report, Verdict, check_fmu
from cosim.check.examination.simulate import UNSTATED, Response, compare, default_tolerance
from cosim.check.reference import Tolerance, read_reference, read_series
from cosim.errors import InputError
from cosim.system.description import Variable

pytestmark = pytest.mark.slow

Maker = Callable[..., Path]

MANIFEST = """<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
    fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref" fmi-ls:fmi-ls-version="1.0.0-alpha.1"
    fmi-ls:fmi-ls-description="Layered Standard providing information on related files included in an FMU.">
  <Related {related}/>
</fmiReferences>
"""
EXPERIMENTS = """<?xml version="1.0" encoding="UTF-8"?>
<Experiments name="all">
  <Experiment name="ramp" description="up and on" {attributes}>
    {transient}
    <Parameters source="ramp.ssv"/>
    <Stimuli source="in%20puts.csv"/>
    <References source="ramp_ref.csv">
      <Annotations><Annotation type="drillstring-cosim.tolerances">
        <Tolerance variable="y" absolute="{tolerance}" reason="closed form"/>
        <Tolerance variable="steps" reason="as many as taken"/>
      </Annotation></Annotations>
    </References>
  </Experiment>
</Experiments>
"""
PARAMETERS = """<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="ramp">
  <ssv:Parameters><ssv:Parameter name="gain"><ssv:Real value="3"/></ssv:Parameter></ssv:Parameters>
</ssv:ParameterSet>
"""
TIMES = np.arange(0, 41) * 0.1
SPAN = 'startTime="0" stopTime="4" stepSize="0.1"'
PLACE = "extra/org.fmi-standard.fmi-ls-ref"


def double_integral(t: np.ndarray) -> np.ndarray:
    """y of x' = 3 u, w' = x, y = x + w, where u is 2 until t = 1, then 0, then rises by 1 each second from t = 2."""
    late, rising = np.maximum(t - 1.0, 0.0), np.maximum(t - 2.0, 0.0)
    x = 6.0 * (t - late) + 3.0 * rising**2 / 2.0
    w = 3.0 * (t**2 - late**2) + 3.0 * rising**3 / 6.0
    return x + w


def ramp_files(
    tolerance: float = 1e-12, answer: np.ndarray | None = None, *, old_draft: bool = False
) -> dict[str, str]:
    """The files of an experiment by FMI-LS-REF, by the present draft of its format or the one before."""
    values = double_integral(TIMES) if answer is None else answer
    rows = "\n".join(f"{t!r},{y!r},{k}" for k, (t, y) in enumerate(zip(TIMES.tolist(), values.tolist(), strict=True)))
    form = {
        "attributes": SPAN if old_draft else "",
        "transient": "" if old_draft else f"<TransientSimulation {SPAN}/>",
        "tolerance": repr(tolerance),
    }
    return {
        "fmi-ls-manifest.xml": MANIFEST.format(
            related='type="application/x-ma-hs-experiments" source="all.exp" role="experiment/validation"'
        ),
        "all.exp": EXPERIMENTS.format(**form),
        "ramp.ssv": PARAMETERS,
        "in puts.csv": "time,u\n0,2\n1,2\n1,0\n2,0\n4,2\n",
        "ramp_ref.csv": f"time,y,steps\n{rows}\n",
    }


def folder_of(files: dict[str, str], folder: Path) -> Path:
    folder.mkdir(parents=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def references(report: Report) -> list[Finding]:
    return [finding for finding in report.findings if finding.group is Group.REFERENCE]


def of(report: Report, variable: str) -> Comparison:
    return next(comparison for comparison in report.comparisons if comparison.variable == variable)


@pytest.mark.parametrize("old_draft", [False, True])
def test_inputs_that_jump_and_ramp_are_followed_exactly(make_suspect: Maker, tmp_path: Path, old_draft: bool) -> None:
    folder = folder_of(ramp_files(old_draft=old_draft), tmp_path / "ref")
    report = check_fmu(make_suspect(), folder)
    assert report.passed
    assert [(finding.check, finding.verdict) for finding in references(report)] == [("ramp", Verdict.PASSED)]
    assert of(report, "y").points == len(TIMES)
    assert of(report, "y").difference <= of(report, "y").allowed == 1e-12
    assert of(report, "y").reason == "closed form"


def test_an_fmu_whose_set_up_resets_parameters_is_run_with_those_of_the_experiment(
    make_suspect: Maker, tmp_path: Path
) -> None:
    report = check_fmu(make_suspect("resets in the set-up"), folder_of(ramp_files(), tmp_path / "ref"))
    assert of(report, "y").difference <= of(report, "y").allowed == 1e-12


def test_experiments_inside_the_fmu_are_found(make_suspect: Maker) -> None:
    inside = {f"{PLACE}/{name}": text.encode() for name, text in ramp_files().items()}
    report = check_fmu(make_suspect(files=inside))
    assert [finding.check for finding in references(report)] == ["ramp"]
    assert report.passed


def test_an_fmu_without_experiments_says_so_and_passes(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect())
    assert [finding.verdict for finding in references(report)] == [Verdict.NOT_CHECKED]
    assert "--reference" in references(report)[0].found
    assert report.passed


def test_a_wrong_output_fails_and_the_table_says_where(make_suspect: Maker, tmp_path: Path) -> None:
    report = check_fmu(make_suspect("wrong output"), folder_of(ramp_files(), tmp_path / "ref"))
    assert [finding.check for finding in report.findings if finding.verdict is Verdict.FAILED] == ["ramp"]
    assert "1 of 2 variables wrong (y); y is" in references(report)[0].found
    assert of(report, "y").verdict is Verdict.FAILED
    assert of(report, "steps").verdict is Verdict.PASSED
    assert of(report, "y").difference == pytest.approx(1e-3 * double_integral(TIMES)[-1], rel=1e-6)


def test_a_wrong_reference_fails(make_suspect: Maker, tmp_path: Path) -> None:
    answer = double_integral(TIMES)
    answer[17] += 1e-6
    report = check_fmu(make_suspect(), folder_of(ramp_files(1e-7, answer), tmp_path / "ref"))
    assert not report.passed
    assert of(report, "y").time == pytest.approx(1.7)
    assert of(report, "y").difference == pytest.approx(1e-6, rel=1e-4)
    wider = check_fmu(make_suspect(), folder_of(ramp_files(2e-6, answer), tmp_path / "wide"))
    assert wider.passed


def test_slopes_need_an_fmu_that_claims_to_follow_them(make_suspect: Maker, tmp_path: Path) -> None:
    claim = {'canInterpolateInputs="true"': ""}
    report = check_fmu(make_suspect(replace=claim), folder_of(ramp_files(), tmp_path / "ref"))
    assert references(report)[0].verdict is Verdict.NOT_CHECKED
    assert references(report)[0].found == "u: has slopes, and canInterpolateInputs is not claimed"


def test_the_reference_fmus_layout_is_read(make_suspect: Maker) -> None:
    related = 'type="text/csv" source="Suspect_out.csv" role="result" description="Output of the default experiment"'

    def inside(factor: float) -> dict[str, bytes]:
        rows = "\n".join(f"{t!r},{factor * (t + t * t / 2)!r}" for t in (np.arange(0, 101) * 0.01).tolist())
        files = {"fmi-ls-manifest.xml": MANIFEST.format(related=related), "Suspect_out.csv": f"time,y\n{rows}\n"}
        return {f"{PLACE}/{name}": text.encode() for name, text in files.items()}

    report = check_fmu(make_suspect(files=inside(1.0)))
    assert report.passed
    assert [finding.check for finding in references(report)] == ["Suspect_out"]
    assert of(report, "y").points == 101
    assert of(report, "y").reason == UNSTATED
    assert not check_fmu(make_suspect(files=inside(1.05))).passed


def test_the_cross_check_layout_is_read(make_suspect: Maker, tmp_path: Path) -> None:
    times = (np.arange(0, 21) * 0.1).tolist()
    files = {
        "suspect_in.csv": '"time","u"\n0,4\n2,4\n',
        "suspect_ref.csv": '"time","y","elsewhere"\n' + "".join(f"{t!r},{4 * t + 2 * t * t!r},0\n" for t in times),
        "suspect_ref.opt": "StartTime,0\nStopTime,2\nStepSize,0.05\nRelTol,1e-4\n",
    }
    report = check_fmu(make_suspect(), folder_of(files, tmp_path / "cc"))
    assert report.passed
    assert references(report)[0].done == "40 steps of 0.05 s"
    assert references(report)[0].found.endswith("not in the FMU: elsewhere")


def test_an_unpacked_fmu_serves_as_a_reference(make_suspect: Maker, tmp_path: Path) -> None:
    folder_of(ramp_files(), tmp_path / "unpacked" / PLACE)
    assert check_fmu(make_suspect(), tmp_path / "unpacked").passed


def test_a_folder_without_experiments_is_refused(make_suspect: Maker, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there are no reference experiments; expected fmi-ls-manifest"):
        check_fmu(make_suspect(), tmp_path)
    with pytest.raises(InputError, match="there is no such folder"):
        check_fmu(make_suspect(), tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        (
            "all.exp",
            "ramp.ssv",
            "https://example.org/ramp.ssv",
            "is not a relative path within ref; nothing else is read",
        ),
        ("all.exp", "ramp.ssv", "other.ssv", r"other\.ssv cannot be read"),
        ("all.exp", "ramp.ssv", "../../etc/passwd", "is not a relative path within ref; nothing else is read"),
        ("all.exp", "<Experiments", '<!DOCTYPE x [<!ENTITY y "z">]><Experiments', "has a document type declaration"),
        ("all.exp", 'stepSize="0.1"', 'stepSize="small"', "experiment ramp: stepSize is 'small'; expected a number"),
        ("all.exp", 'source="ramp_ref.csv"', 'source="ramp.h5" type="application/hdf5"', "expected text/csv"),
        ("all.exp", "</Experiments>", "", r"all\.exp is not XML"),
        ("ramp.ssv", 'value="3"', 'value="three"', r"ramp\.ssv breaks the schema of SSP 1\.0"),
        ("ramp_ref.csv", "time,y,steps", "time,y,steps,more", r"ramp_ref\.csv, line 2: expected 4 fields"),
        ("in puts.csv", "1,2\n1,0", "1,2\n0.5,0", r"in puts\.csv: times in the first column are not finite, or fall"),
        ("in puts.csv", "0,2\n", "start,2\n", r"in puts\.csv: could not convert string to float: 'start'"),
    ],
)
def test_broken_references_are_refused_in_one_sentence(
    tmp_path: Path, name: str, old: str, new: str, message: str
) -> None:
    files = ramp_files()
    assert old in files[name]
    files[name] = files[name].replace(old, new, 1)
    with pytest.raises(InputError, match=message):
        read_reference(folder_of(files, tmp_path / "ref"), ("suspect",))


def test_broken_references_inside_the_fmu_fail_it(make_suspect: Maker) -> None:
    files = {f"{PLACE}/{name}": text.encode() for name, text in ramp_files().items() if name != "ramp.ssv"}
    report = check_fmu(make_suspect(files=files))
    assert references(report)[0].verdict is Verdict.FAILED
    assert references(report)[0].found.startswith("ramp.ssv cannot be read")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name="gain"', 'name="pain"', "parameter pain: expected the name of a variable with a start value"),
        ('Real value="3"', 'String value="three"', "gain is 'three'; expected a number"),
        ('value="3"', 'value="30"', "gain is 30"),
    ],
)
def test_parameters_that_do_not_fit_fail_the_experiment(
    make_suspect: Maker, tmp_path: Path, old: str, new: str, message: str
) -> None:
    files = ramp_files()
    files["ramp.ssv"] = files["ramp.ssv"].replace(old, new)
    report = check_fmu(make_suspect(), folder_of(files, tmp_path / "ref"))
    assert message in references(report)[0].found
    assert not report.passed


def test_an_fmu_that_crashes_in_an_experiment_fails_it_alone(make_suspect: Maker, tmp_path: Path) -> None:
    claim = {'maxOutputDerivativeOrder="1"': ""}
    report = check_fmu(make_suspect("crash at gain 3", claim), folder_of(ramp_files(), tmp_path / "ref"))
    assert [finding.check for finding in report.findings if finding.verdict is Verdict.FAILED] == ["ramp"]
    assert references(report)[0].found == "crashed in fmi2DoStep (SIGABRT)"


# comparisons

REAL = Variable("y", 0, "Real", "output", "continuous")
COUNT = Variable("n", 0, "Integer", "output", "discrete")


def compared(
    variable: Variable, times: list[float], values: list[float], csv: str, tolerance: Tolerance, folder: Path
) -> Comparison:
    (folder / "ref.csv").write_text(f"time,{variable.name}\n{csv}")
    result = Response(variable, np.array(times), np.array(values))
    found = compare("run", result, read_series(folder / "ref.csv"), tolerance)
    assert found is not None
    return found


def test_allowed_is_absolute_and_relative_together(tmp_path: Path) -> None:
    tolerance = Tolerance("", absolute=0.1, relative=0.01)
    found = compared(REAL, [0, 1], [0.0, 101.05], "0,0\n1,100\n", tolerance, tmp_path)
    assert (found.time, found.difference, found.allowed) == (1.0, pytest.approx(1.05), pytest.approx(1.1))
    assert found.verdict is Verdict.PASSED
    assert compared(REAL, [0, 1], [0.0, 101.2], "0,0\n1,100\n", tolerance, tmp_path).verdict is Verdict.FAILED


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_never_right(tmp_path: Path, value: float) -> None:
    found = compared(REAL, [0, 1], [0.0, value], "0,0\n1,0\n", Tolerance("", absolute=1e300), tmp_path)
    assert found.verdict is Verdict.FAILED


def test_nothing_allowed_means_equal(tmp_path: Path) -> None:
    assert compared(COUNT, [0, 1], [0, 3], "0,0\n1,3\n", Tolerance(""), tmp_path).verdict is Verdict.PASSED
    assert compared(COUNT, [0, 1], [0, 2], "0,0\n1,3\n", Tolerance(""), tmp_path).share == np.inf


def test_where_the_reference_jumps_either_side_is_right(tmp_path: Path) -> None:
    for value, verdict in ((1.0, Verdict.PASSED), (2.0, Verdict.PASSED), (2.1, Verdict.FAILED)):
        found = compared(REAL, [0, 1, 2], [1.0, value, 2.0], "0,1\n1,1\n1,2\n2,2\n", Tolerance(""), tmp_path)
        assert found.verdict is verdict


def test_an_event_one_step_late_is_right_only_where_time_is_allowed(tmp_path: Path) -> None:
    csv = "0,0\n1,1\n2,1\n3,1\n"
    late = [0.0, 0.0, 1.0, 1.0]
    for variable in (REAL, COUNT):
        assert compared(variable, [0, 1, 2, 3], late, csv, Tolerance("", time=1.0), tmp_path).verdict is Verdict.PASSED
        assert compared(variable, [0, 1, 2, 3], late, csv, Tolerance("", time=0.0), tmp_path).verdict is Verdict.FAILED
    later = [0.0, 0.0, 0.0, 1.0]
    assert compared(COUNT, [0, 1, 2, 3], later, csv, Tolerance("", time=1.0), tmp_path).verdict is Verdict.FAILED


def test_a_continuous_result_is_read_between_its_points_a_discrete_one_never(tmp_path: Path) -> None:
    csv = "0.5,1\n1.5,3\n"
    assert compared(REAL, [0, 1, 2], [0.0, 2.0, 4.0], csv, Tolerance("", 1e-12), tmp_path).points == 2
    result = Response(COUNT, np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 4.0]))
    (tmp_path / "ref.csv").write_text(f"time,n\n{csv}")
    assert compare("run", result, read_series(tmp_path / "ref.csv"), Tolerance("")) is None


def test_added_up_times_are_the_same_times(tmp_path: Path) -> None:
    times = np.cumsum([0.0] + [0.1] * 30)
    csv = "".join(f"{0.1 * k!r},{k}\n" for k in range(31))
    assert compared(COUNT, times.tolist(), list(range(31)), csv, Tolerance(""), tmp_path).points == 31


def test_unstated_tolerances_follow_the_range_of_the_reference() -> None:
    values = np.array([5.0, 25.0, 15.0])
    assert default_tolerance(REAL, values, 0.1) == Tolerance(UNSTATED, absolute=0.02, time=0.1)
    assert default_tolerance(REAL, np.array([3.0, 3.0]), 0.1).absolute == 3e-3
    assert default_tolerance(COUNT, values, 0.1).absolute == 0.0


MODE = '<Enumeration declaredType="Mode"'
CHOOSING = {
    '<Integer start="0"/>': f'{MODE} start="1"/>',
    'name="n_next" valueReference="1" causality="output" variability="discrete"><Integer/>': (
        f'name="n_next" valueReference="1" causality="output" variability="discrete">{MODE}/>'
    ),
    '<Item name="fast" value="5"/>': "".join(
        f'<Item name="{name}" value="{value}"/>' for name, value in (("twice", 2), ("fast", 5), ("six", 6))
    ),
}


@pytest.mark.parametrize(
    ("last", "verdict"), [("six", Verdict.PASSED), ("fast", Verdict.FAILED), ("6", Verdict.PASSED)]
)
def test_columns_of_enumerations_hold_names_of_items(
    make_probe: Maker, tmp_path: Path, last: str, verdict: Verdict
) -> None:
    folder = tmp_path / "reference"
    folder.mkdir()
    (folder / "probe_in.csv").write_text("time,n\n0,slow\n0.5,fast\n1,5\n")
    (folder / "probe_ref.csv").write_text(f"time,n_next\n0.25,twice\n1,{last}\n")
    (folder / "probe_ref.opt").write_text("StartTime,0\nStopTime,1\nStepSize,0.25\n")
    report = check_fmu(make_probe(replace=CHOOSING), folder)
    (found,) = (each for each in report.findings if each.group is Group.REFERENCE)
    assert found.verdict is verdict, found
