"""Sections 4 and 5 of docs/wire-format.md, and what tiles of both kinds share: coder, models, head."""


# 4 and 5
class Coder:
    def __init__(self, data):
        self.data, self.at, self.range, self.code = data, 0, (1 << 64) - 1, 0
        self.shift()
        self.shift()

    def shift(self):
        word = self.data[self.at:self.at + 4].ljust(4, b"\0")
        self.at += 4
        self.code = (self.code << 32 | int.from_bytes(word, "big")) & ((1 << 64) - 1)

    def normalise(self):
        if self.range < 1 << 32:
            self.range <<= 32
            self.shift()

    def bit(self, model):
        fast, slow, age = model
        split = (self.range >> 16) * ((fast + slow) >> 1)
        one = self.code < split
        r = 1 + age // 2 if age < 6 else 4
        s = 1 + age // 2 if age < 6 else 4 if age < 16 else 5 if age < 40 else 6 if age < 100 else 7
        if one:
            self.range = split
            model[0] += (65535 - fast) >> r
            model[1] += (65535 - slow) >> s
        else:
            self.code -= split
            self.range -= split
            model[0] -= fast >> r
            model[1] -= slow >> s
        model[2] = min(age + 1, 126)
        self.normalise()
        return int(one)

    def symbol(self, *models):
        part = self.range >> 15
        value = min(self.code // part, 32767)
        mean = (sum(m[i] for m in models) + len(models) - 1 for i in range(1, 16))
        bounds = [0] + [total // len(models) for total in mean] + [32768]
        found = max(i for i in range(16) if bounds[i] <= value)
        self.code -= bounds[found] * part
        self.range = (bounds[found + 1] - bounds[found]) * part
        for model in models:
            age = model[0]
            rate = 2 if age < 2 else 3 if age < 4 else 4 if age < 10 else 5 if age < 24 else 6
            for i in range(1, 16):
                model[i] += (8 * i + (32640 if i > found else 0) - model[i]) >> rate
            model[0] = min(age + 1, 24)
        self.normalise()
        return found

    def raw(self, n):
        self.range >>= n
        value = min(self.code // self.range, (1 << n) - 1)
        self.code -= value * self.range
        self.normalise()
        return value

    def tree(self, models, n):
        node = 1
        for _ in range(n):
            node = 2 * node + self.bit(models[node])
        return node - (1 << n)

    def ended(self):
        return len(self.data) <= self.at <= len(self.data) + 8


class Models:
    """A tile's own copy of the starting models, by name."""

    def __init__(self, start):
        for name, models in start.items():
            setattr(self, name, [list(m) for m in models])


def fresh(count):
    return [[32768, 32768, 0] for _ in range(count)]


def bad_unless(condition):
    if not condition:
        raise ValueError("kBadSymbol or kFieldRange")


def pos(n):
    return max(1, (n - 1).bit_length())


def head(coder, stream):
    wide, high = (stream.width + 7) // 8, (stream.height + 7) // 8
    verbatim = coder.raw(1)
    bx, by = coder.raw(pos(wide)), coder.raw(pos(high))
    bw, bh = coder.raw(min(pos(wide), 8)) + 1, coder.raw(min(pos(high), 8)) + 1
    bad_unless(bx + bw <= wide and by + bh <= high)
    stream.mixed = not verbatim and not stream.raw and bool(stream.key["flags"] & 2) and coder.raw(1) == 1
    return verbatim, bx, by, bw, bh


def pixels_of(stream, bx, by, bw, bh):
    return (range(bx * 8, min((bx + bw) * 8, stream.width)),
            range(by * 8, min((by + bh) * 8, stream.height)))
