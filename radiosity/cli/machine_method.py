"""``--method machine``: frusta on the simulated machine."""

from contextlib import contextmanager

import click

from golden.base.errors import InputError
from radiosity.cli.console import console
from radiosity.cli.golden.choices import PRESETS, TOPOLOGIES
from radiosity.cli.hw.choices import POLICIES
from radiosity.cli.parameters import ASSIGNMENTS, FILE
from radiosity.flow.simulator.simulated_machines import MOST_CLUSTERS, checked_clusters, opened_machine

__all__ = ["MachineMethod"]

_MEMORY = (
    click.option("--topology", type=click.Choice(TOPOLOGIES), help="Set the machine's network.  [default: the "
                 "preset's]"),
    click.option("--policy", type=click.Choice(POLICIES), help="Set the policy of the machine's caches.  [default: the "
                 "preset's]"),
    click.option("--latency", type=click.IntRange(1, 10_000), default=10, help="Set the latency of main memory in "
                 "cycles."),
    click.option("--spread", type=click.IntRange(0, 10_000), default=0, help="Add a random delay of at most so many "
                 "cycles to each read of main memory, and return replies in any order."),
    click.option("--memory-seed", type=click.IntRange(0, (1 << 32) - 1), default=1, help="Set the seed of --spread."))
_CLUSTERS = click.option("--clusters", type=int, help="Set the number of the machine's clusters, a power of two up to "
                         f"{MOST_CLUSTERS}.  [default: the preset's]")
_PRESET = click.option("--preset", type=click.Choice(PRESETS), default="paper", help="Choose the machine's parameters.")
_WORK = (
    click.option("--ratio", type=int, default=64, help="Schedule by a sparse casting: one ray of so many."),
    click.option("--casts", type=click.IntRange(1, 1000), default=3, help="Repeat the cast on the machine, each "
                 "time as a job. The first one loads the tables; from the third one on caches are the same."),
    click.option("--timeline", type=FILE, help="Write a chart of the machine's utilization in the last cast to this "
                 ".svg."),
    click.option("--waves", type=FILE, help="Write the machine's signals in the last cast to this .vcd: "
                 "ports and named registers of all modules, some 0.03 MB a cycle with four clusters; beside it a save "
                 "file for GTKWave (.gtkw). Needs a second, slower build of the machine."),
    click.option("--waves-begin", type=click.IntRange(0), default=0, help="Set the first cycle of the signals, "
                 "counted from the doorbell."),
    click.option("--waves-cycles", type=click.IntRange(1, 1_000_000), default=2000, help="Set the number of cycles of "
                 "the signals."),
    click.option("--csv", "table", type=FILE, help="Write the machine's counters to this .csv: a row for each cluster "
                 "of each cast."))


class MachineMethod:
    """A value of ``--method``: it casts by the RTL; the modules of the simulator are imported when it does.

    Members
    -------
    name, about
        The value, and sentences for the help of ``--method``.
    options
        Decorators that add its options to every command that casts.
    frustum_options
        Those that it adds to ``cast`` in place of ``options``. ``cast`` has ``--clusters``, ``--preset`` and ``-P``
        itself, and passes their values.
    """

    name = "machine"
    about = ("The machine is simulated: its RTL finds the hits. Unless -P sets them, it has icu.rays=16384, "
             "icu.generation_bits=8 and a run-ahead depth (ctu.run_ahead) of at least 6. Its choice of --cell is the "
             "one with the fewest predicted cycles.")
    options = (_CLUSTERS, *_MEMORY, _PRESET, ASSIGNMENTS)
    frustum_options = (*_MEMORY, *_WORK)

    def check(self, *, clusters, frustum=(1, 1), timeline=None, waves=None, table=None, **options):
        """Refuse options that cannot be used, before the work starts.

        ``frustum``, where it is known: columns and rows of the largest frustum.

        Raises
        ------
        InputError
            An option is out of range.
        """
        from golden.base.output import check_outputs
        from radiosity.charts.chart import check_chart

        check_chart(timeline)
        check_outputs(waves, suffixes=(".vcd",))
        check_outputs(table, suffixes=(".csv",))
        checked_clusters(clusters)
        most = 1 << self._config(self._given(**options), clusters=clusters, **options).icu.side_bits
        if max(frustum) > most:
            raise InputError(f"machine: A frustum must have at most {most} columns and rows of rays (icu.side_bits), "
                             f"not {frustum[0]} x {frustum[1]}")

    @contextmanager
    def frusta(self, scene, *, cell, shadows=False, **options):
        """A caster of frusta with ``counts()`` for the report, ``summary()`` for people, ``ray_kinds``, the kinds of
        rays of an image that it casts, and ``specular_rays``, how many of the others it has cast.

        Parameters
        ----------
        scene
            The patches.
        cell
            Cell size, or None for the one with the fewest predicted cycles.
        shadows
            Whether it must cast shadow frusta.
        """
        from radiosity.flow.simulator.machine_caster import MachineCaster
        from radiosity.flow.simulator.simulation_config import overridden

        given = self._given(**options)
        config = self._config(given, shadows=shadows, **options)
        MachineCaster.check(config)
        with self._machine(config, **options) as machine:
            yield MachineCaster(scene, machine, cell=cell, changes=overridden(config, given),
                                progress=console().progress)

    def cast(self, record, geometry, config, *, cell, weights, title, **options):
        """A `radiosity.tasks.machine_cast.MachineCastResult` of one frustum.

        Parameters
        ----------
        record, geometry, weights
            See `radiosity.tasks.machine_cast.MachineCast`.
        config
            The configuration, without what the simulation overrides.
        cell
            As of `frusta`.
        title
            What is cast into what, for charts.
        """
        from radiosity.flow.simulator.simulation_config import overridden
        from radiosity.tasks.machine_cast import CastOptions, MachineCast, WaveformWindow

        simulated = self._config(config, **options)
        waves = options["waves"]
        window = waves and WaveformWindow(path=waves, begin=options["waves_begin"], cycles=options["waves_cycles"])
        given = CastOptions(cell=cell, waves=window, timeline=options["timeline"], counters=options["table"],
                            changes=overridden(simulated, config),
                            **{name: options[name] for name in ("ratio", "casts")})
        prepared = MachineCast(record, geometry, weights, simulated, given)
        with self._machine(simulated, traced=waves is not None, **options) as machine:
            return prepared.run(machine, title=title, progress=console().progress)

    @staticmethod
    def _given(*, preset, assignments, **_):
        from golden.engine.config import PRESETS as CONFIGURATIONS

        return CONFIGURATIONS[preset].with_parameters(assignments)

    @staticmethod
    def _config(config, *, clusters, topology, assignments, shadows=False, **_):
        from radiosity.flow.simulator.simulation_config import simulation_config

        return simulation_config(config, clusters=clusters, topology=topology, shadows=shadows,
                                 given=tuple(one.partition("=")[0] for one in assignments))

    @staticmethod
    def _machine(config, *, policy, latency, spread, memory_seed, traced=False, **_):
        return opened_machine(config, policy=policy, latency=latency, spread=spread, memory_seed=memory_seed,
                              traced=traced, progress=console().progress)
