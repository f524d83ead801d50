import pytest
from click.testing import CliRunner

from radiosity.cli.golden.main import main
from tb.golden.engine.stimulus.stored_stimulus import read_stimulus


def run(*arguments):
    return CliRunner().invoke(main, ["stimulus", *map(str, arguments)])


def test_a_file_is_written_and_its_fields_are_listed(tmp_path):
    path = tmp_path / "sbb.npz"
    result = run("icu.sbb", "-n", 7, "--seed", 3, "--preset", "tiny", "-P", "icu.uv_bits=6", "-o", path)
    assert result.exit_code == 0, result.stderr
    header, arrays = read_stimulus(path)
    assert (header["count"], header["seed"], header["parameters"]["icu.uv_bits"]) == (7, 3, 6)
    assert len(arrays["column_first"]) == 7
    assert len(result.stdout.splitlines()) == 1 + len(header["fields"])


@pytest.mark.parametrize(("arguments", "says"), [
    (("sbb2", "-o", "a.npz"), "Block must be one of cordic, "), (("sbb", "-o", "a.txt"), "must end in .npz or .jsonl"),
    (("sbb", "-n", "0", "-o", "a.npz"), "Count must be"), (("sbb", "--seed", "-3", "-o", "a.npz"), "Seed must be"),
    (("sbb",), "Missing option"), (("sbb", "-P", "icu.uv_bits=99", "-o", "a.npz"), "must be 0 to 12")])
def test_bad_input_is_one_line_and_no_file(arguments, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert says in result.stderr
    assert not list(tmp_path.iterdir())
