"""Integrates the equations of motion by one-step methods, with projection after the steps: `simulate`."""

from mbproj.integrate.reporting.report import Report, Worst
from mbproj.integrate.simulate import Recorder, simulate

__all__ = ["Recorder", "Report", "Worst", "simulate"]
