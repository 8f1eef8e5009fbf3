"""Controllers at an equilibrium: the states that they set no longer change."""

from __future__ import annotations

from dataclasses import replace

from mbproj.functions.program import CHANNELS, Op, apply, variable
from mbproj.functions.program_set import flatten
from mbproj.model.channels import ChannelKind, Channels
from mbproj.model.system import System


def settled(system: System) -> System:
    """Return the system in which a held state x follows x' = (value set by its controller) - x. At rest both are
    equal."""
    actions, states, channels = system.actions, system.states, system.channels
    if not actions.size:
        return system
    known = zip(channels.kind.tolist(), channels.index.tolist(), strict=True)
    found = {(ChannelKind(kind), index): at for at, (kind, index) in enumerate(known)}
    rates = [states.programs.program(k) for k in range(states.size)]
    for entry, state in enumerate(actions.state.tolist()):
        own = variable(CHANNELS + found.setdefault((ChannelKind.STATE, state), len(found)))
        to = actions.programs.program(entry)
        rates[state] = replace(to, code=apply(Op.SUBTRACT, to.code, own))
    return replace(system, channels=Channels.of(list(found)), states=replace(states, programs=flatten(rates)))
