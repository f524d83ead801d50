import re
import subprocess
from importlib.metadata import version
from pathlib import Path

import pytest

from golden.base.package_version import DISTRIBUTION, package_version

ROOT = Path(__file__).parents[3]

INSTALLED = version(DISTRIBUTION)


@pytest.fixture
def git(tmp_path, monkeypatch):
    """Runs git in a new repository, beside no settings of the user."""
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", "/dev/null")
    for name in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{name}_NAME", "nobody")
        monkeypatch.setenv(f"GIT_{name}_EMAIL", "nobody@localhost")

    def run(*words):
        done = subprocess.run(["git", "-C", tmp_path, *words], check=True, capture_output=True, text=True)
        return done.stdout.strip()

    run("init", "--quiet")
    run("commit", "--quiet", "--allow-empty", "-m", "first")
    return run


def test_a_checkout_names_tag_and_commit(git, tmp_path):
    first = git("rev-parse", "--short", "HEAD")
    assert package_version(tmp_path) == f"{INSTALLED}+g{first}"
    git("tag", "v0.2.0")
    assert package_version(tmp_path) == "0.2.0"
    git("commit", "--quiet", "--allow-empty", "-m", "second")
    second = git("rev-parse", "--short", "HEAD")
    assert package_version(tmp_path) == f"0.2.0+1.g{second}"
    git("tag", "experiment")
    assert package_version(tmp_path) == f"0.2.0+1.g{second}"


def test_a_changed_checkout_says_so(git, tmp_path):
    (tmp_path / "a.py").write_text("x = 1")
    git("add", "a.py")
    assert package_version(tmp_path).endswith(f"+g{git('rev-parse', '--short', 'HEAD')}.dirty")
    git("tag", "0.2.0")
    assert package_version(tmp_path) == f"0.2.0+0.g{git('rev-parse', '--short', 'HEAD')}.dirty"


def test_elsewhere_it_is_that_of_the_installed_package(tmp_path, monkeypatch):
    assert package_version(tmp_path) == INSTALLED
    (tmp_path / ".git").mkdir()  # no repository
    assert package_version(tmp_path) == INSTALLED
    monkeypatch.setenv("PATH", "")
    assert package_version(ROOT) == INSTALLED


def test_no_other_module_identifies_code_by_the_version():
    """A version is that of many commits: what must be of the same code compares `source_digest`."""
    reads = re.compile(r"""version\(["']radiosity-engine""")
    found = {path.relative_to(ROOT).as_posix() for folder in ("benchmarks", "golden", "radiosity")
             for path in (ROOT / folder).rglob("*.py") if reads.search(path.read_text())}
    assert not found
