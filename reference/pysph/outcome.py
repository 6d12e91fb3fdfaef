"""How a run ends before its time."""


class Refusal(Exception):
    """What is asked for and PySPH has not, or is not given, in words."""


class Ended(Exception):
    """A run that ends by itself: a status of the protocol, and the reason."""

    def __init__(self, status, reason):
        super().__init__(reason)
        self.status = status
