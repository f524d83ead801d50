"""``bench``: the benchmarks, one module of `benchmarks` each."""

import ast
import importlib
import sys
from functools import cache
from pathlib import Path

import click

from radiosity.cli.command_line import CommandLine, Task

__all__ = ["bench"]

_PACKAGE = "benchmarks"
_FOLDER = Path(__file__).parents[2] / _PACKAGE


class _Benchmarks(CommandLine):
    """The modules with a command ``main``. A module is imported when it is run, and read for the list."""

    def list_commands(self, ctx):
        """The names of the modules."""
        return sorted(path.stem for path in _FOLDER.glob("*.py") if _has_main(path))

    def get_command(self, ctx, cmd_name):
        """The command of a module."""
        if cmd_name not in self.list_commands(ctx):
            return None
        # They are beside the package, in a checkout only.
        if str(_FOLDER.parent) not in sys.path:
            sys.path.append(str(_FOLDER.parent))
        command = importlib.import_module(f"{_PACKAGE}.{cmd_name}").main
        return Task(cmd_name, params=command.params, callback=command.callback, help=command.help,
                    epilog=command.epilog)

    def format_commands(self, ctx, formatter):
        """List names with the first sentence of each module, which is not imported."""
        rows = [(name, _first_sentence(_FOLDER / f"{name}.py")) for name in self.list_commands(ctx)]
        if rows:
            with formatter.section("Benchmarks"):
                formatter.write_dl(rows)


@cache
def _has_main(path):
    return any(isinstance(node, ast.FunctionDef) and node.name == "main" for node in ast.parse(path.read_text()).body)


def _first_sentence(path):
    return (ast.get_docstring(ast.parse(path.read_text())) or "").partition("\n\n")[0].replace("\n", " ")


@click.command("bench", cls=_Benchmarks, no_args_is_help=False, short_help="Run a benchmark.")
def bench():
    """Run a benchmark and write its tables to out/bench/.

    Minutes of processor time: schedule, shooting, thesis_memory and traversal 1 each, daylight and reference_hits 2,
    references and network 4, network_load 6, mesh_sizes 8, view_factors 12, istructure 23, scaling 24, machines with
    --calibrate 26, thesis_networks 1, thesis_speedup 2 for each scene, paper_machine 5, gathering 2, koan 10,
    merge 7, torus 5, engine with --clusters 1 --clusters 4 4, jobs 10 for each scene. All of `make bench` take about
    three hours.
    """
