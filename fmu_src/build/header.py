"""ds_table.h and ds_table.c of a model: the interface table as the C adapter and the C core see it."""

from __future__ import annotations

from math import isinf

from ..schema import Model, Variable

KINDS = {
    "Real": "DS_REAL",
    "Integer": "DS_INTEGER",
    "Enumeration": "DS_INTEGER",
    "Boolean": "DS_BOOLEAN",
    "String": "DS_STRING",
}


def table_header(model: Model, guid: str) -> str:
    """Return ds_table.h of a model: its value references as an enumeration, and what it can do as macros."""
    texts = sum(1 for variable in model.variables if variable.kind == "String")
    names = [f"DS_{variable.name}" for variable in model.variables]
    references = ",\n    ".join([f"{names[0]} = 0", *names[1:], "DS_VARIABLES"])
    return f"""\
/* Made from the interface table of {model.name}: edit fmu_src/fmus/{model.name}/interface.py instead. */
#ifndef DS_TABLE_H
#define DS_TABLE_H

#include "ds_interface.h"
#include "ds_linkage.h"

#define DS_MODEL {c_string(model.name)}
#define DS_GUID {c_string(guid)}
#define DS_TEXTS {texts} /* number of String variables */
#define DS_PROVIDES_DIRECTIONAL_DERIVATIVE {int(model.has_real_inputs)}
#define DS_LOG_CATEGORIES {len(model.log_categories)}
{_most(model)}
/* value references */
enum {{
    {references}
}};

DS_SHARED const ds_variable ds_variables[DS_VARIABLES];
DS_SHARED const char *const ds_log_categories[DS_LOG_CATEGORIES];

#endif
"""


def table_source(model: Model) -> str:
    """Return ds_table.c of a model, which defines what ds_table.h declares."""
    slots = {variable.name: slot for slot, variable in enumerate(v for v in model.variables if v.kind == "String")}
    rows = ",\n".join(f"    {_row(variable, slots.get(variable.name))}" for variable in model.variables)
    categories = ",\n".join(f"    {c_string(name)}" for name, _ in model.log_categories)
    return f"""\
/* Made from the interface table of {model.name}: edit fmu_src/fmus/{model.name}/interface.py instead. */
#include "ds_table.h"

#include <float.h>

DS_SHARED_DATA const ds_variable ds_variables[DS_VARIABLES] = {{
{rows}
}};

DS_SHARED_DATA const char *const ds_log_categories[DS_LOG_CATEGORIES] = {{
{categories}
}};
"""


def c_string(text: str) -> str:
    """Return a C string literal; characters beyond ASCII become their UTF-8 bytes in octal."""
    out: list[str] = []
    for byte in text.encode("utf-8"):
        char = chr(byte)
        out.append(char if 0x20 <= byte < 0x7F and char not in '"\\?' else f"\\{byte:03o}")
    return f'"{"".join(out)}"'


def _most(model: Model) -> str:
    """Return the greatest value of every parameter that counts something, for arrays that have to hold as many."""
    counts = [v for v in model.select("parameter") if v.kind == "Integer" and v.maximum is not None]
    return "".join(f"#define DS_MOST_{count.name} {int(count.bounds[1])}\n" for count in counts)


def _row(variable: Variable, slot: int | None) -> str:
    start = slot if slot is not None else variable.start
    low, high = variable.bounds
    cells = (
        c_string(variable.name),
        c_string(variable.unit or ""),
        c_string(variable.kind),
        KINDS[variable.kind],
        _role(variable),
        repr(float(start if start is not None else 0.0)),
        "-DBL_MAX" if isinf(low) else repr(low),
        "DBL_MAX" if isinf(high) else repr(high),
    )
    return "{" + ", ".join(cells) + "}"


def _role(variable: Variable) -> str:
    if variable.causality == "parameter":
        return "DS_TUNABLE" if variable.variability == "tunable" else "DS_FIXED"
    return "DS_INPUT" if variable.causality == "input" else "DS_OUTPUT"
