"""The page on the format of jobs."""

from pathlib import Path

from golden.engine.jobs.job_tables import job_tables

PAGE = Path(__file__).parents[2] / "docs" / "job-format.md"


def test_the_page_shows_the_formats():
    assert PAGE.read_text().endswith(job_tables())
