"""Tell on the documentation page how to compile the sources of a native FMU."""

from __future__ import annotations

from ..schema import Model
from .prose import paragraphs


def compiling(model: Model) -> str:
    """Return how to compile the sources of a native FMU, and what makes the result the same to the last bit, as HTML.

    FMI 2.0.4, section 2.3, wants this in the documentation.
    """
    return paragraphs(f"""
`sources/{model.name}.c` is the one file to compile, as C99; it includes the others. The FMI headers are not in the FMU:
they are the importer's. FMPy brings its own:

`fmpy compile {model.name}.fmu`

or, with a folder HEADERS that holds `fmi2Functions.h`, `fmi2FunctionTypes.h` and `fmi2TypesPlatform.h`,

`cc -std=c99 -O2 -fPIC -shared -DFMI2_OVERRIDE_FUNCTION_PREFIX -I HEADERS sources/{model.name}.c -lm -o {model.name}.so`

Linked into a program instead, without that definition, the functions have the prefix `{model.name}_`, and no other name
is visible, so several FMUs can be linked together.

Any compiler whose double precision is that of IEEE 754, without excess precision, gives the bits of the libraries in
this FMU. Fusing products with sums is switched off in `ds_arithmetic.h`; `-ffast-math` is refused. On x86 with 32 bits
add `-msse2 -mfpmath=sse`. GCC and Clang have been tried, MSVC has not.
""")
