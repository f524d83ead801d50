"""Workers make the picture of one process, with its counts."""

import logging

from distributed import LocalCluster

from golden.light.in_flight import InFlight
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin import builtin_scene
from radiosity.workers.pool import WorkerPool

LOCAL = {"n_workers": 2, "threads_per_worker": 2, "processes": False, "protocol": "tcp", "host": "127.0.0.1",
         "dashboard_address": "127.0.0.1:0", "scheduler_kwargs": {"dashboard": False},
         "silence_logs": logging.CRITICAL}


def test_workers_make_the_picture_of_one_process_with_its_counts(monkeypatch):
    monkeypatch.setattr(InFlight, "of", lambda *_, **__: InFlight(primary=100))
    # With glass, mirrors and a light without an area.
    scene = builtin_scene("mountain:1")
    settings = RenderSettings(width=16, height=12, samples=4, light_samples=1, rays=(16, 4), jobs=1,
                              method="grid")
    whole = render(scene, camera=scene.camera, settings=settings)
    with LocalCluster(**LOCAL) as cluster, WorkerPool(cluster.scheduler_address, method="grid") as workers:
        parts = render(scene, camera=scene.camera, settings=settings, workers=workers)
    for name in ("image", "tests", "steps"):
        assert getattr(parts, name).tobytes() == getattr(whole, name).tobytes()
    for stats in (whole.stats, parts.stats):
        del stats["seconds"]
    assert parts.stats == whole.stats
    assert parts.stats["rays"]["shadow"]["rays"] > 0
    assert parts.stats["rays"]["refraction"]["rays"] > 0
