"""The platform class: one word for machines that round alike."""

import platform

import numpy as np
import pytest

from plumbline.fingerprint import fingerprint, platform_class


@pytest.mark.parametrize(
    ("machine", "told", "level"),
    [("x86_64", {"SIMD Extensions": {"found": ["X86_V3", "X86_V4"]}}, "-v4"),
     ("x86_64", {"SIMD Extensions": {"found": ["SSSE3", "AVX2", "FMA3", "AVX512_SKX"]}}, "-v4"),
     ("x86_64", {"SIMD Extensions": {"found": ["X86_V3"]}}, "-v3"),
     ("AMD64", {"SIMD Extensions": {"found": ["FMA3", "AVX2"]}}, "-v3"),
     ("x86_64", {"SIMD Extensions": {"baseline": ["X86_V2"]}}, "-v2"),  # NumPy leaves out what is empty
     ("x86_64", {}, "-v2"),
     ("aarch64", {"SIMD Extensions": {"found": ["ASIMDHP"]}}, "")],
)  # fmt: skip
def test_it_is_system_architecture_and_level_of_vector_instructions(monkeypatch, machine, told, level):
    monkeypatch.setattr(platform, "machine", lambda: machine)
    monkeypatch.setattr(platform, "system", lambda: "Linux")
    monkeypatch.setattr(np, "show_config", lambda mode: told)
    assert platform_class() == f"linux-{machine.lower()}{level}"


def test_every_run_tells_its_own():
    assert fingerprint()["platform class"] == platform_class()
