"""Summary of a render's statistics."""

from golden.base.plural import counted

__all__ = ["summary"]


def summary(stats: dict) -> str:
    """The statistics of `golden.render.two_pass.RenderResult` as text."""
    solver, settings = stats["solver"], stats["settings"]
    converged = "" if solver["converged"] else ", not converged"
    lines = [f"{stats['scene']}: {counted(stats['patches'], 'patch')}, {counted(stats['elements'], 'element')}, "
             f"{counted(stats['nodes'], 'node')}, {settings['width']}x{settings['height']} pixels",
             f"{settings['solver']}: {counted(solver['steps'], 'step')}{converged}",
             "",
             f"{'rays':12} {'count':>12} {'hit':>7} {'tests/ray':>10} {'steps/ray':>10}"]
    # Embree says nothing about the work of a ray.
    shows_work = settings["method"] != "embree"
    if not shows_work:
        lines[-1] = lines[-1][:33].rstrip()
    for kind, counts in {**stats["rays"], "total": stats["total"]}.items():
        rays = max(1, counts["rays"])
        work = f" {counts['tests'] / rays:10.2f} {counts['steps'] / rays:10.2f}" if shows_work else ""
        lines.append(f"{kind:12} {counts['rays']:12,} {counts['hits'] / rays:7.1%}{work}")
    lines += ["", f"{'seconds':24} {sum(stats['seconds'].values()):8.2f}"]
    lines += [f"  {stage:22} {seconds:8.2f}" for stage, seconds in stats["seconds"].items()]
    if stats["noise"]:
        noise = stats["noise"]
        lines.append(f"noise {noise['estimate']:.2%} by {noise['samples']:.1f} rays a pixel; above the requested "
                     f"{settings['noise']:.2%}: {counted(noise['above'], 'pixel')}")
    lines += [f"not computed: {what}" for what in stats["not_computed"]]
    return "\n".join(lines)
