"""Sections and lists behind each other: each is read out when all of the one before has left."""

from random import Random

from golden.engine.ctu.sector import Sector
from golden.engine.icu.window_walk import ray_address
from hw.icu.section_read_out import SectionReadOut
from radiosity.flow.package.example.frustum_load import tiles
from tb.lib.configurations import config_of
from tb.lib.responder import Responder
from tb.lib.schedules import Schedule, ScheduleBench

CONFIG = config_of({"icu.rays": 256, "icu.side_bits": 6, "icu.shadow_bits": 7})
BLOCKED = {"inverse": (1 << CONFIG.numbers.inverse.width) - 1, "patch": 3, "u": 1, "v": 2}
MISS = dict.fromkeys(BLOCKED, 0)
SECTION = Sector(5, 8, 2, 4)
# Rays of each bank's list; bank and kind of what is read out.
COUNTS, ORDER = (70, 3), ((0, 1), (1, 0), (0, 0), (1, 1), (0, 1), (1, 1))


def hit(ray):
    """All odd rays of the ray memory are blocked."""
    return BLOCKED if ray & 1 else MISS


def words(rays):
    """What comes of a list: no hit beside its bits."""
    bits = sum(ray["ray"] % 2 * ray["is_ray"] << k for k, ray in enumerate(rays))
    count = -(-len(rays) // 64)
    return [{"column": k, "row": 0, "hit": MISS, "last": int(k == count - 1), "is_word": 1,
             "word": bits >> 64 * k & (1 << 64) - 1} for k in range(count)]


def hits(section, across):
    """What comes of a section; a word beside a hit is any."""
    places = [(column, row) for row in range(section.first_row, section.end_row)
              for column in range(section.first_column, section.end_column)]
    return [{"column": column, "row": row, "last": int(column + 1 == section.end_column and row + 1 == section.end_row),
             "hit": hit(ray_address(column - section.first_column, row - section.first_row, across, CONFIG.icu)),
             "is_word": 0} for column, row in places]


def test_each_is_read_when_the_one_before_has_left():
    random, across = Random(1), tiles(SECTION, CONFIG)[0]
    lists = [[{"bank": bank, "ray": random.randrange(256), "is_ray": random.randrange(2), "last": int(k == count - 1)}
              for k in range(count)] for bank, count in enumerate(COUNTS)]
    expected = [one for bank, is_list in ORDER for one in (words(lists[bank]) if is_list else hits(SECTION, across))]
    found = ScheduleBench(SectionReadOut(config=CONFIG), idle_limit=60).run(Schedule(
        first={"i_ray": [ray for rays in lists for ray in rays]},
        items={"i": [(0, {"bank": bank, "section": vars(SECTION), "tiles_across": across, "is_list": is_list})
                     for bank, is_list in ORDER]},
        stalls={"o": [random.choice((0, 3, 30)) for _ in expected]}),
        Responder("o_read", "i_hit", lambda read: [hit(read["ray"])], 7))["o"]
    assert [{name: one[name] for name in given} for one, given in zip(found, expected, strict=True)] == expected
