"""Radiosity Engine: pictures, view factors and rays in Python, the simulated machine and its hardware.

The names of ``__all__`` are the public interface, described in docs/python.md; a module is imported when a name of it
is first used. All other modules may change with any version.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from golden.base.errors import InputError as InputError
    from golden.base.errors import InputWarning as InputWarning
    from golden.cast.rays import Hits as Hits
    from golden.cast.rays import Rays as Rays
    from golden.light.factors.exchange import Exchange as Exchange
    from golden.light.factors.interface import view_factors as view_factors
    from golden.light.factors.view_factors import ViewFactors as ViewFactors
    from golden.light.photometry.sensors import Sensors as Sensors
    from golden.light.preview import Preview as Preview
    from golden.light.solvers.on_demand import Shooting as Shooting
    from golden.render.render_statistics import RenderStatistics as RenderStatistics
    from golden.render.two_pass import RenderResult as RenderResult
    from golden.scene.camera import Camera as Camera
    from golden.scene.lights import DirectionalLight as DirectionalLight
    from golden.scene.lights import PointLight as PointLight
    from golden.scene.material import Material as Material
    from golden.scene.scene import Scene as Scene
    from radiosity.api.cast import cast as cast
    from radiosity.api.export_verilog import export_verilog as export_verilog
    from radiosity.api.lights import luminaire as luminaire
    from radiosity.api.lights import sky as sky
    from radiosity.api.load import load as load
    from radiosity.api.machine import machine as machine
    from radiosity.api.render import render as render
    from radiosity.api.visible import visible as visible
    from radiosity.tasks.machine_cast import MachineCastResult as MachineCastResult

    __version__: str

# The module of each public name.
_MODULES = {
    "Camera": "golden.scene.camera",
    "DirectionalLight": "golden.scene.lights",
    "Exchange": "golden.light.factors.exchange",
    "Hits": "golden.cast.rays",
    "InputError": "golden.base.errors",
    "InputWarning": "golden.base.errors",
    "MachineCastResult": "radiosity.tasks.machine_cast",
    "Material": "golden.scene.material",
    "PointLight": "golden.scene.lights",
    "Preview": "golden.light.preview",
    "Rays": "golden.cast.rays",
    "RenderResult": "golden.render.two_pass",
    "RenderStatistics": "golden.render.render_statistics",
    "Scene": "golden.scene.scene",
    "Sensors": "golden.light.photometry.sensors",
    "Shooting": "golden.light.solvers.on_demand",
    "ViewFactors": "golden.light.factors.view_factors",
    "cast": "radiosity.api.cast",
    "export_verilog": "radiosity.api.export_verilog",
    "load": "radiosity.api.load",
    "luminaire": "radiosity.api.lights",
    "machine": "radiosity.api.machine",
    "render": "radiosity.api.render",
    "sky": "radiosity.api.lights",
    "view_factors": "golden.light.factors.interface",
    "visible": "radiosity.api.visible",
}

__all__ = [*_MODULES, "__version__"]


def __getattr__(name: str) -> object:
    if name == "__version__":
        from golden.base.package_version import package_version

        return package_version()
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(import_module(_MODULES[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
