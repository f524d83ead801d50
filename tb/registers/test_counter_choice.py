"""Which counter's value is reported."""

import random

import pytest
from amaranth.sim import Simulator

from hw.registers.counter_choice import CounterChoice

GROUPS = 1, 5, 8, 3
COUNT = sum(GROUPS)


@pytest.mark.parametrize("bits", [5, 6])
def test_every_counter(bits):
    choice, generator = CounterChoice(groups=GROUPS, number_bits=bits), random.Random(bits)
    values = generator.sample(range(1 << 32), COUNT)
    numbers = [*range(COUNT), *generator.choices(range(COUNT), k=200)]
    simulator, reported = Simulator(choice), []
    simulator.add_clock(1e-8)

    async def request(ctx):
        for number, value in enumerate(values):
            ctx.set(choice.counts[number], value)
        for number in [*numbers, *[0] * choice.latency]:
            ctx.set(choice.counter, number)
            reported.append(ctx.get(choice.count))
            await ctx.tick()

    simulator.add_testbench(request)
    simulator.run()
    assert reported[choice.latency:] == [values[number] for number in numbers]


def test_a_value_is_that_of_the_cycle_behind_its_number():
    choice = CounterChoice(groups=GROUPS, number_bits=5)
    simulator, reported = Simulator(choice), []
    simulator.add_clock(1e-8)

    async def count(ctx):
        for cycle in range(60):
            for number in range(COUNT):
                ctx.set(choice.counts[number], 1000 * number + cycle)
            ctx.set(choice.counter, cycle % COUNT)
            reported.append(ctx.get(choice.count))
            await ctx.tick()

    simulator.add_testbench(count)
    simulator.run()
    assert reported[choice.latency:] == [1000 * (cycle % COUNT) + cycle + 1 for cycle in range(60 - choice.latency)]


def test_init_wrong_number_bits():
    with pytest.raises(ValueError, match=f"^Number bits must be enough for {COUNT} counters, not 4$"):
        CounterChoice(groups=GROUPS, number_bits=4)
