"""abi.py says the same as the C header, according to the C compiler."""

import ctypes
import re
import shutil
import subprocess

import pytest

from paradesc.bridge import BACKENDS, CHOICES, abi
from shapes import ROOT

HEADERS = [ROOT / "native" / "include" / "paradesc" / name for name in ("paradesc.h", "images.h")]
ENUMERATORS = {
    "PDESC_ABI_VERSION": abi.ABI_VERSION,
    "PDESC_OK": abi.STATUS_OK,
    "PDESC_ERROR_UNKNOWN": abi.STATUS_UNKNOWN,
    "PDESC_ERROR_INVALID_ARGUMENT": abi.STATUS_INVALID_ARGUMENT,
    "PDESC_ERROR_INVALID_OPERATION": abi.STATUS_INVALID_OPERATION,
    "PDESC_ERROR_OUT_OF_MEMORY": abi.STATUS_OUT_OF_MEMORY,
    "PDESC_ERROR_UNSUPPORTED": abi.STATUS_UNSUPPORTED,
    "PDESC_ERROR_CANCELLED": abi.STATUS_CANCELLED,
    "PDESC_ERROR_DEVICE_LOST": abi.STATUS_DEVICE_LOST,
    "PDESC_MASK_NO_FACE": abi.MASK_NO_FACE,
    "PDESC_MASK_BOUNDARY": abi.MASK_BOUNDARY,
    "PDESC_MASK_LOW_COVERAGE": abi.MASK_LOW_COVERAGE,
    "PDESC_MASK_NO_TEXEL": abi.MASK_NO_TEXEL,
}
# Choices are numbered by their order in our table.
for OPTION, NUMBERS in {"backend": BACKENDS, **{name: numbers for name, (numbers, _) in CHOICES.items()}}.items():
    for NAME, NUMBER in NUMBERS.items():
        ENUMERATORS[f"PDESC_{OPTION.removesuffix('_unit')}_{NAME}".upper().replace("-", "_")] = NUMBER


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Every size, offset and constant as the C compiler sees it, by the expression that was printed."""
    compiler = shutil.which("cc")
    assert compiler, "the C compiler that built the library is needed"
    expressions = list(ENUMERATORS)
    for struct, name in abi.STRUCTS.items():
        expressions.append(f"sizeof({name})")
        expressions += [f"offsetof({name}, {member})" for member, *_ in struct._fields_]
    lines = "".join(f'printf("%s=%lld\\n", "{text}", (long long)({text}));' for text in expressions)
    folder = tmp_path_factory.mktemp("abi")
    source = folder / "layout.c"
    source.write_text(
        f'#include <stddef.h>\n#include <stdio.h>\n#include "{HEADERS[0]}"\nint main(void) {{ {lines} return 0; }}\n'
    )
    subprocess.run([compiler, "-std=c99", "-o", folder / "layout", source], check=True)
    output = subprocess.run([folder / "layout"], check=True, capture_output=True, text=True).stdout
    return {text: int(value) for text, value in (line.rsplit("=", 1) for line in output.splitlines())}


@pytest.mark.parametrize("struct", abi.STRUCTS, ids=abi.STRUCTS.get)
def test_struct_is_laid_out_as_in_c(compiled, struct):
    name = abi.STRUCTS[struct]
    assert ctypes.sizeof(struct) == compiled[f"sizeof({name})"]
    for member, *_ in struct._fields_:
        assert getattr(struct, member).offset == compiled[f"offsetof({name}, {member})"], member


def test_constants_are_those_of_c(compiled):
    assert {name: compiled[name] for name in ENUMERATORS} == ENUMERATORS


def declarations():
    """The text of the headers without comments, one after the other, as the first includes the second."""
    return re.sub(r"/\*.*?\*/", "", "".join(header.read_text() for header in HEADERS), flags=re.S)


def test_every_function_of_the_header_is_declared_in_its_order():
    assert re.findall(r"PDESC_API[^;(]*?(pdesc_\w+)\(", declarations()) == list(abi.FUNCTIONS)


def test_every_function_takes_as_many_arguments_as_in_the_header():
    for name, arguments in re.findall(r"PDESC_API[^;(]*?(pdesc_\w+)\(([^;]*)\);", declarations()):
        expected = 0 if arguments.strip() == "void" else arguments.count(",") + 1
        assert len(abi.FUNCTIONS[name][1]) == expected, name
