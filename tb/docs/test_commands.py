"""Commands that pages show are run, and the figures that they quote are compared with what the commands print."""

import ast
import contextlib
import gc
import importlib
import re
import shlex
import subprocess
import sys
import warnings
from dataclasses import replace
from itertools import pairwise

import click
import pytest
from amaranth.hdl import UnusedElaboratable
from click.testing import CliRunner

import radiosity.cli.golden.main
import radiosity.cli.hw.main
import radiosity.cli.main
import tb.bugs.command
from golden.engine.config import PRESETS
from hw.board.board_shell import BoardShell
from radiosity.flow.synthesis.family import Area
from radiosity.flow.synthesis.flow import Bitstream, Clock
from radiosity.flow.synthesis.history import Commit
from radiosity.flow.synthesis.report import UNITS, Row
from tb.docs.language import ROOT
from tb.docs.page_commands import TABLE, Command, commands_of, files_of, missing_rows, pages, tables_of
from tb.lib.drawn import drawn

PAGES = {page: commands_of(page) for page in pages()}
COMMANDS = [command for commands in PAGES.values() for command in commands]

# Programs that are not the project's.
FOREIGN = ("source", "git", "apt-get", "openFPGALoader", "stty")

# What takes longer than a commit's tests may: a simulator's build, place and route, images, simulated machines, of
# which tb/radiosity has smaller ones; or reads what this writes.
SLOW = re.compile(r"--method machine|--manifest|radiosity (render|formfactors (?!furnace)|verilog|board|report|machine)"
                  r"|-m golden render|-m hw (report|verilog|board)")
# Benchmarks: a nightly runs a third of them and compares their tables on all pages.
BENCHMARK = re.compile(r"radiosity bench \w")
# Place and route of whole blocks and of the board, which take hours: they run here without the tools of synthesis.
# Other tests have these tools, with smaller units.
WITHOUT_TOOLS = re.compile(r"hw report (.*--record|\w+(?!.*--unit))"
                           r"|(radiosity|-m hw) board(?!.*--no-bitstream)")
# Commands whose work another test runs: the module, its test, and a call in it.
ELSEWHERE = {
    WITHOUT_TOOLS.pattern: [
        ("tb/radiosity/flow/synthesis/test_figures.py", "test_area_and_clock_stay", "measure("),
        ("tb/radiosity/flow/synthesis/test_report.py", "test_another_family_has_its_cells_and_no_clock",
         '["report", "ctu"'),
        ("tb/radiosity/flow/board/test_ulx3s.py", "test_bitstream", "build(")],
    "radiosity exchange canyon": [("tb/docs/test_view_factors_page.py", "test_the_tutorial", "invoke(")],
    "-m hw figures": [("tb/radiosity/flow/synthesis/test_figures.py", "test_the_command_writes_what_has_changed",
                       '["figures"]')],
    "make (setup|litex|lint|test|sim|coverage|formal|nightly|bugs|release|report|bench)": [],
    "make demo": [("tb/docs/test_commands.py", "test_the_demo", "demo")],
    "make pictures": [("tb/radiosity/test_reports.py", "test_pictures_report_their_files", 'run("pictures"')],
    "make docs": [("tb/docs/test_site.py", "test_the_site_is_built_and_all_its_links_lead_somewhere",
                   '"tb.docs"')],
    "tb.board.picture": [("tb/board/test_decoder.py", "test_picture", "main")],
    "tb.runs": [("tb/runs/test_nightly.py", "ran", "run_shards(")],
    "tb.system.ray_campaign": [("tb/system/test_ray_campaign.py", "test_no_ray_differs", "cast_campaign(")],
    "-m tb.lib.cpu_times": [("tb/lib/test_cpu_times.py", "test_tenths_share_out_all_seconds_from_the_largest_folder_on",
                             "tenths(")],
    "tb.system.cycles": [("tb/docs/test_cycles.py", "test_cycles_are_those_of_the_page", "cycles_of(")],
    r"(^|-m )pytest": [],
}
# Settings of the programs, which a command keeps from its first context: its help option goes by both names.
HELP = {"help_option_names": ["-h", "--help"]}


def entry(words):
    """A command line of the project and its arguments, or nothing."""
    for name, main in (("golden", radiosity.cli.golden.main.main), ("hw", radiosity.cli.hw.main.main)):
        if words[:3] == ("python", "-m", name):
            return main, words[3:]
    return (radiosity.cli.main.main, words[1:]) if words[0] == "radiosity" else None


def below(group, words):
    """The command that words name, and the words behind its name."""
    words = list(words)
    while words and isinstance(group, click.Group) and (found := group.get_command(click.Context(group), words[0])):
        group = found
        words.pop(0)
    return group, words


def is_run(command):
    """Whether a command can be run here as it stands."""
    if command.not_run or not command.is_complete:
        return False
    return not is_mention(command) if entry(command.words) else command.words[:2] == ("python", "-c")


def elsewhere(command):
    """The entries of `ELSEWHERE` for a command."""
    return [pattern for pattern in ELSEWHERE if re.search(pattern, shlex.join(command.words))]


def is_elsewhere(command):
    """Whether a command is not run with the others of its page."""
    return bool(BENCHMARK.search(shlex.join(command.words)) or elsewhere(command))


def parse(group, words):
    """Give words to a command as a shell does, without running it."""
    command, rest = below(group, words)
    if rest or not isinstance(command, click.Group):
        command.make_context(command.name, rest, **HELP)


def is_mention(command):
    """Whether a sentence only names a command, without the arguments that it needs."""
    group, words = entry(command.words)
    try:
        parse(group, words)
    except click.MissingParameter:
        return True
    except click.exceptions.Exit:
        return False
    return isinstance(below(group, words)[0], click.Group)


def options_of(command):
    """All options of a command and of those below it."""
    context = click.Context(command, **HELP)
    parameters = command.get_params(context)
    found = {option for parameter in parameters for option in (*parameter.opts, *parameter.secondary_opts)}
    names = command.list_commands(context) if isinstance(command, click.Group) else []
    return found.union(*(options_of(command.get_command(context, name)) for name in names))


def _is_open(word):
    """Whether a word of a sentence stands for something else, or is an option."""
    return word.startswith("-") or not Command(ROOT, 0, (word,)).is_complete


@pytest.mark.parametrize("command", [one for one in COMMANDS if entry(one.words)], ids=str)
def test_commands_are_accepted(command, tmp_path, monkeypatch):
    group, words = entry(command.words)
    if not command.is_complete or command.not_run or is_mention(command):
        found, rest = below(group, words)
        assert not isinstance(found, click.Group) or all(_is_open(word) for word in rest)
        assert {word for word in rest if word.startswith("-")} <= options_of(found)
        return
    monkeypatch.chdir(tmp_path)
    with contextlib.suppress(click.exceptions.Exit):
        parse(group, words)


@pytest.fixture(scope="module")
def known_options():
    return set().union(*map(options_of, (radiosity.cli.main.main, radiosity.cli.golden.main.main,
                                         radiosity.cli.hw.main.main, tb.bugs.command.main)))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_options_named_in_sentences_exist(page, known_options):
    # Options of nextpnr and FuseSoC are not the project's.
    text = re.sub(r'--nextpnr\s+"[^"]*"', "--nextpnr", re.sub(r"<!--.*?-->", "", page.read_text(), flags=re.DOTALL))
    text = re.sub(r"^fusesoc .*", "", text, flags=re.MULTILINE)
    assert set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", text)) <= known_options


@pytest.mark.parametrize("command", [one for one in COMMANDS if not entry(one.words)], ids=str)
def test_other_commands_exist(command):
    words = [word for word in command.words if not re.match(r"[A-Z_]+=", word)]
    if words[0] == "make":
        targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
        assert set(words[1:]) - {"TARGET"} <= targets
    elif "pytest" in (words[0], *words[2:3]):
        paths = [word for word in words[1:] if word.startswith("tb/")]
        plugins = [word for option, word in pairwise(words) if option == "-p"]
        assert paths or plugins
        assert all(importlib.util.find_spec(plugin) for plugin in plugins)
        assert all((ROOT / path).exists() for path in paths)
    elif words[:2] == ["python", "-m"]:
        assert importlib.util.find_spec(words[2])
    else:
        assert words[0] in FOREIGN or words[:2] == ["python", "-c"]


def run(command, folder):
    """What a command prints."""
    if command.words[0] == "python" and command.words[1] == "-c":
        return subprocess.run([sys.executable, *command.words[1:]], cwd=folder, check=True, capture_output=True,
                              text=True).stdout
    group, words = entry(command.words)
    result = CliRunner().invoke(group, list(words))
    assert result.exit_code == 0, f"{command}\n{result.output}"
    return result.output


def check(commands, folder):
    """Run them in a folder and compare what they print. Some write into docs/, which a checkout has."""
    (folder / "docs" / "formats").mkdir(parents=True)
    for command in commands:
        printed = " ".join(run(command, folder).split())
        for text in command.prints:
            assert " ".join(text.split()) in printed, f"{command} prints\n{printed}"


def is_slow(command):
    """Whether a command takes longer than a commit's tests may, or reads what such a one writes."""
    return bool(SLOW.search(shlex.join(command.words))) or command.words[1] == "-c"


RUN = {page: [one for one in commands if not is_elsewhere(one) and is_run(one)] for page, commands in PAGES.items()}
QUICK = sorted({one.words for commands in RUN.values() for one in commands if not is_slow(one)})


@pytest.mark.parametrize("words", QUICK, ids=shlex.join)
def test_quick_commands_do_what_all_pages_say(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first, *others = (one for commands in RUN.values() for one in commands if one.words == words)
    check([replace(first, prints=[*first.prints, *(text for one in others for text in one.prints)])], tmp_path)


@pytest.mark.nightly
@pytest.mark.parametrize("page", [page for page in PAGES if any(map(is_slow, RUN[page]))], ids=lambda page: page.name)
def test_slow_commands_do_what_their_page_says(page, tmp_path, monkeypatch):
    """With the others of the page, whose files they may read."""
    monkeypatch.chdir(tmp_path)
    check(RUN[page], tmp_path)


@pytest.mark.parametrize("command", [one for one in COMMANDS if not one.not_run and one.is_complete], ids=str)
def test_every_command_is_run(command):
    if entry(command.words):
        # A sentence that only names a command says nothing that could be wrong but the name.
        assert is_mention(command) or is_run(command)
    else:
        assert is_run(command) or command.words[0] in FOREIGN or len(elsewhere(command)) == 1, (
            f"{command}: name the test that runs it in ELSEWHERE")


@pytest.mark.parametrize("where", [where for tests in ELSEWHERE.values() for where in tests], ids=lambda one: one[1])
def test_tests_that_run_commands_exist(where):
    module, name, called = where
    tests = {node.name: ast.unparse(node) for node in ast.parse((ROOT / module).read_text()).body
             if isinstance(node, ast.FunctionDef)}
    assert called.replace('"', "'") in tests[name]


@pytest.mark.parametrize("pattern", ELSEWHERE)
def test_every_entry_is_of_a_command(pattern):
    assert any(pattern in elsewhere(command) for command in COMMANDS)


@pytest.fixture
def no_tools(monkeypatch):
    """Synthesis, place and route that measure nothing; figures are recorded nowhere."""
    def measure(block, unit, config, folder, *, family, seeds, options, routability_driven):
        assert unit in UNITS[block]
        made.append(unit)
        folder.mkdir(parents=True, exist_ok=True)
        return Row(unit=unit, area=Area(lut=1, ff=2, dsp=3, bram=4),
                   latency=None,
                   clocks=tuple(Clock(seed=seed, mhz=100.0, path="a path", mhz_grade_8=130.0) for seed in seeds))

    made = []
    monkeypatch.setattr("radiosity.flow.synthesis.report.measure", measure)
    monkeypatch.setattr("radiosity.flow.synthesis.history.measured_commit", lambda: Commit(name="a", date="2026-01-01"))
    monkeypatch.setattr("radiosity.flow.synthesis.history.add_record", lambda record: None)
    monkeypatch.setattr("radiosity.flow.synthesis.flow.tool_versions", lambda **_: "tools")
    monkeypatch.setattr("radiosity.flow.board.ulx3s.build",
                        lambda shell, folder, *, seeds, **_: made.append(type(shell)) or (
                            [folder / "board.bit"], Bitstream(
                                area=Area(lut=1, ff=2, dsp=3, bram=4), synthesis_seconds=1, route_seconds=(2,),
                                clocks=tuple(Clock(seed=seed, mhz=50.0, path="a path") for seed in seeds))))
    yield made
    # A board that is never elaborated is collected with a warning.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnusedElaboratable)
        gc.collect()


LONG = [one for one in COMMANDS if WITHOUT_TOOLS.pattern in elsewhere(one) and is_run(one)]


@pytest.mark.parametrize("command", [one for one in LONG if "--unit" in one.words], ids=str)
def test_units_of_commands_exist(command):
    words = command.words
    assert words[words.index("--unit") + 1] in UNITS[words[words.index("report") + 1]]


# They elaborate units and a board, as other tests of a commit do.
@pytest.mark.nightly
@pytest.mark.parametrize("command", LONG, ids=str)
def test_long_commands_run_without_the_tools_of_synthesis(command, no_tools, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run(command, tmp_path)
    assert no_tools
    assert list(tmp_path.rglob("*.md")) or no_tools[0] is BoardShell


@pytest.mark.parametrize("command", [one for one in COMMANDS if one.words[0] == "make" and one.is_complete], ids=str)
def test_targets_have_recipes(command):
    done = subprocess.run(["make", "--dry-run", *command.words[1:]], cwd=ROOT, check=True, capture_output=True,
                          text=True)
    assert done.stdout


@pytest.mark.nightly
@pytest.mark.parametrize("command", [one for one in COMMANDS if "pytest" in (one.words[0], *one.words[2:3])
                                     and not one.not_run], ids=str)
def test_tests_of_pages_are_found(command):
    given = command.words[1 if command.words[0] == "pytest" else 3:]
    done = subprocess.run([sys.executable, "-m", "pytest", "--collect-only", "-q", *given], cwd=ROOT, check=True,
                          capture_output=True, text=True)
    assert re.search(r"^\d+(/\d+)? tests collected", done.stdout, re.MULTILINE)


@pytest.mark.nightly
def test_the_demo(tmp_path):
    result = CliRunner().invoke(radiosity.cli.main.main, ["demo", str(tmp_path / "demo")])
    assert result.exit_code == 0, result.output
    page = (tmp_path / "demo" / "index.html").read_text()
    assert "0 of 16,384 hits differ" in page
    assert "96 of 96 hemispheres sum to 1 exactly" in page


@pytest.mark.parametrize("command", [one for one in COMMANDS if "-P" in one.words and one.is_complete], ids=str)
def test_parameters_of_commands_exist(command):
    given = [word for option, word in pairwise(command.words) if option == "-P"]
    assert PRESETS["small"].with_parameters(given)


TABLES = [(page, words, rows) for page in PAGES for words, rows in tables_of(page.read_text()).items()]


@pytest.mark.parametrize(("page", "words"), [table[:2] for table in TABLES], ids=str)
def test_tables_quote_commands_that_exist(page, words):
    assert words[:2] == ("radiosity", "bench")
    assert entry(words)
    assert any(shlex.join(one.words) == shlex.join(words) for one in PAGES[page])


def test_every_comment_belongs_to_a_table():
    """One that does not would leave its table uncompared."""
    for page in PAGES:
        text = page.read_text()
        assert text.count("<!-- table: ") == len(files_of(text)) + len(TABLE.findall(text)), page


def test_every_file_of_data_is_compared():
    quoted = {path for page in PAGES for path, _ in files_of(page.read_text())}
    assert quoted == {f"data/{path.name}" for path in (ROOT / "docs" / "data").iterdir()}


BENCHMARKS = sorted({one.words for one in COMMANDS if BENCHMARK.search(shlex.join(one.words)) and is_run(one)})


@pytest.mark.nightly
@pytest.mark.parametrize("words", drawn(BENCHMARKS, 13), ids=shlex.join)
def test_benchmarks_print_what_pages_quote(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check([one for one in COMMANDS if one.words == words][:1], tmp_path)
    written = "\n".join(path.read_text() for path in tmp_path.rglob("*.md"))
    assert {page.name: missing_rows(rows, written) for page, quoted, rows in TABLES
            if quoted == words and missing_rows(rows, written)} == {}


def test_every_benchmark_is_shown():
    assert {words[2] for words in BENCHMARKS} == set(radiosity.cli.main.main.get_command(None,
                                                                                         "bench").list_commands(None))


def test_rows_are_compared_as_far_as_they_are_quoted():
    text = "<!-- table: radiosity bench x -->\n\n| scene | 4 |\n|---|---|\n| `lobby` | 1,227 |\n| `man` | 0.35 |\n"
    (rows,) = tables_of(text).values()
    assert rows == [["lobby", "1,227"], ["man", "0.35"]]
    assert not missing_rows(rows, "| man | 4 | 0.3541 |\n| lobby | 1227 | 2 |\n")
    assert missing_rows(rows, "| man | 4 | 0.36 |\n| lobby | 1227 | 2 |\n") == [["man", "0.35"]]
    assert missing_rows(rows, "| lobby | 0.35 |\n| man | 1227 |\n") == rows
    assert not missing_rows([["man", "**1.4 (2)**"]], "| man | **1.4 (2)** |\n")


def test_figures_of_prints_stand_on_their_page():
    for page, commands in PAGES.items():
        shown = re.sub(r"<!--.*?-->", "", page.read_text(), flags=re.DOTALL).replace(",", "").replace(" %", "%")
        for command in commands:
            for number in set(re.findall(r"\d+(?:\.\d+)?", " ".join(command.prints))) - {"0"}:
                assert re.search(rf"(?<![\d.]){re.escape(number)}(?![\d]|\.\d)", shown), f"{command}: {number}"


@pytest.mark.parametrize(("text", "expected"), [
    ("```sh\nmake test    # all\npython -m golden cast \\\n  x --rays 4x4\n```",
     ["make test", "python -m golden cast x --rays 4x4"]),
    ("Say `radiosity scenes` or `make`, not `scenes` or\n\n```python\nmake = 1\n```", ["radiosity scenes"])])
def test_commands_of_a_page(text, expected):
    assert [shlex.join(command.words) for command in commands_of(ROOT / "x.md", text)] == expected


def test_what_a_command_prints_belongs_to_the_last_one():
    first, second = commands_of(ROOT / "x.md", "`make a` and `make b`<!-- prints: 3 rays --><!-- not run: slow -->")
    assert (first.prints, first.not_run) == ([], None)
    assert (second.prints, second.not_run) == (["3 rays"], "slow")
    with pytest.raises(AssertionError, match="put it behind the block"):
        commands_of(ROOT / "x.md", "`make a`\n\n<!-- not run: slow -->\n\n```sh\nmake b\n```\n")


@pytest.mark.parametrize(("words", "complete"), [
    ("radiosity render SCENE -o FILE.png", False), ("make sim BLOCK=icu", True),
    ("radiosity render cornell -o x.png", True), ("python -m hw report BLOCK", False),
    ("radiosity stimulus x -P PATH=VALUE", False), ("radiosity bench ...", False)])
def test_a_placeholder_is_known(words, complete):
    assert Command(ROOT / "x.md", 1, tuple(words.split())).is_complete == complete


def test_programs_are_found():
    assert {one.words[0] for one in COMMANDS} >= {"radiosity", "make", "pytest", "python"}
