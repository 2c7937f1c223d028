"""What the page knows of the models: it is read from their interface tables."""

from __future__ import annotations

from fmu_src.console.core import core_tables
from fmu_src.fmus import MODELS


def test_what_counts_with_some_items_alone_names_a_choice_and_its_items() -> None:
    found = {
        f"{model}.{name}": (row["by"], row["with"])
        for model, rows in core_tables().items()
        for name, row in rows.items()
        if "by" in row
    }
    for port, (choice, items) in found.items():
        model = port.split(".")[0]
        table = {variable.name: variable for variable in MODELS[model].variables}
        assert set(items) < set(table[choice].items), port
    assert found["SpeedPid.K_p"] == ("mode", ["own"])
    assert found["TopDrive.rate_limit"] == ("mode", ["speed", "servo"])
    assert found["MudPulse.bit_rate"] == ("link", ["own"])


def test_parameters_have_the_start_range_and_unit_of_their_table_and_outputs_no_text() -> None:
    tables = core_tables()
    row = tables["SoftTorque"]["P"]
    assert (row["start"], row["low"], row["high"], row["unit"]) == (450.0, 1e-3, 1e9, "N.m.s/rad")
    assert row["text"] == "Damping the string is to meet"
    assert tables["TopDrive"]["seed"]["whole"]
    assert tables["WeightOnBitLaw"]["K_w"]["tunable"]
    assert "tunable" not in row
    assert "text" not in tables["SoftTorque"]["Omega"]
    for model, rows in tables.items():
        assert [each["reference"] for each in rows.values()] == list(range(len(MODELS[model].variables)))
