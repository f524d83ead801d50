from hw.noc.link_sender import LinkSender
from tb.lib.bench import Bench
from tb.lib.grants import RoundRobin

CHANNELS, MESSAGES, DEPTH = 2, 2, 3
# By destination the channel in which a packet enters.
ENTRY = [0, 1, 1, 0]


class TestLinkSender(Bench):
    component, variants = LinkSender, ({},)
    arguments = {"bits": 16, "entry": ENTRY, "channels": CHANNELS, "messages": MESSAGES, "depth": DEPTH}

    def model(self, config):
        """A packet stays in the channel of its first flit; a flit takes a credit of its channel."""
        self.credits, kept, sent, rule = [DEPTH] * CHANNELS * MESSAGES, [0] * MESSAGES, None, RoundRobin()
        given = yield
        while True:
            flits = {k: flit for k in range(MESSAGES) if (flit := getattr(given, f"i__{k}"))}
            kept = [ENTRY[flits[k]["data"] % len(ENTRY)] if k in flits and flits[k]["first"] else kept[k]
                    for k in range(MESSAGES)]
            channels = [k * CHANNELS + kept[k] for k in range(MESSAGES)]
            granted = rule.grant(flits, [k for k in flits if self.credits[channels[k]]])
            outputs = {"o": sent, **{f"i__{k}": k == granted for k in range(MESSAGES)}}
            sent = None
            if granted is not None:
                rule.accept(granted)
                sent = {"flit": flits[granted], "channel": channels[granted]}
                self.credits[channels[granted]] -= 1
            for channel in range(CHANNELS * MESSAGES):
                self.credits[channel] += given.i_credit >> channel & 1
            given = yield outputs

    def drive(self, given, random):
        """Credits of flits that have been sent."""
        given.i_credit = sum(1 << channel for channel, count in enumerate(self.credits)
                             if count < DEPTH and random.random() < 0.3)
