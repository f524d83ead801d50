import pytest

from tb.docs.verification import collected, report_of


@pytest.fixture(scope="module")
def items():
    return collected("tb/formal/test_queue.py", "tb/formal/test_fork.py")


def test_proofs_are_listed_with_their_negative_controls(items):
    text = report_of(items)
    assert "### queue" in text
    assert "Order and count" in text
    assert "| holds | queue: depth=1; queue: depth=2;" in text
    assert "| can be reached | queue: depth=1;" in text
    assert "| must fail | queue: is ready when full; queue: delivers an item twice" in text
    assert "queue: another depth" in text


def test_tests_are_counted_and_cases_named(items):
    text = report_of(items)
    assert "| `tb/formal` | 2 |" in text
    assert "equally near with a smaller id" in text
    counted = next(line for line in text.splitlines() if line.startswith("| `test_queue.py`")).split("|")
    assert sum(int(count) for count in counted[2:5] if count.strip()) == sum(
        item.path.name == "test_queue.py" for item in items) > 5
