"""What a result depends on besides the scene: machine, system, Python, and the version of everything that computes."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from importlib import metadata
from pathlib import Path

COMPUTES = ("plumbline", "numpy", "scipy", "numba", "osqp", "pybullet", "mujoco-core", "mujoco", "pymunk", "python-fcl")
ROOT = Path(__file__).resolve().parents[1]


def fingerprint() -> dict[str, object]:
    """Facts about this environment, name -> value."""
    facts: dict[str, object] = {
        "system": f"{platform.system()} {platform.release()}",
        "machine": platform.machine(),
        "platform class": platform_class(),
        "processor": processor(),
        "processors": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "libc": " ".join(platform.libc_ver()).strip() or "unknown",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": {name: version for name in COMPUTES if (version := installed(name))},
    }
    commit = source_commit()
    return facts | ({"source": commit} if commit else {})


def platform_class() -> str:
    """What decides how this machine rounds: system, architecture and, on x86, the level of its vector instructions.

    "linux-x86_64-v3": libraries choose their kernels by it.  Machines of one class give the same bits where the
    same program runs; of other classes that cannot be expected.
    """
    from numpy import show_config

    found = set(show_config(mode="dicts").get("SIMD Extensions", {}).get("found", ()))  # absent where there is none
    levels = {"v4": {"X86_V4", "AVX512_SKX"}, "v3": {"X86_V3", "AVX2", "FMA3"}}
    level = next((name for name, marks in levels.items() if marks & found), "v2")
    parts = [platform.system().lower(), platform.machine().lower()]
    return "-".join([*parts, level] if parts[1] in ("x86_64", "amd64") else parts)


def processor() -> str:
    """Name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "unknown")


def installed(distribution: str) -> str:
    """Version of an installed package, or ""."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""


def source_commit() -> str:
    """Commit of the checkout this runs from, marked if it has changes; "" if it does not run from one."""
    if not (ROOT / ".git").exists():
        return ""
    try:
        said = subprocess.run(
            ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"],
            capture_output=True,
            text=True,
            timeout=5.0,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return said.stdout.strip()


def python_line() -> str:
    """Python and where it lives."""
    return f"{platform.python_version()} ({sys.executable})"
