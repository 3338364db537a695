"""Exceptions to a rule that may become fewer and never more: a file with lines `NAME NUMBER`, and # before comments."""


def read(path):
    pairs = [line.rsplit(" ", 1) for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return {name: int(number) for name, number in pairs}


def text(numbers):
    return "".join(f"{name} {number}\n" for name, number in sorted(numbers.items()))


def exceeding(path, found):
    """Names whose number is larger than the list allows."""
    allowed = read(path)
    return [name for name, number in found.items() if number > allowed.get(name, 0)]


def stale(path, found):
    """Lines that allow more than there is."""
    return [f"{name} {number}: found {found.get(name, 0)}" for name, number in read(path).items() if found.get(name, 0) < number]
