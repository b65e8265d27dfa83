#!/usr/bin/env python3
"""A second decoder, written from docs/wire-format.md alone, to prove that the page says enough:
it must give the counts and floats of expected.txt. Slow and short; section numbers are the page's.

Streams of points (points_*) are not covered yet.

usage: reference_decoder.py FOLDER MAKE_GOLDEN     FOLDER holds *.plc and expected.txt; MAKE_GOLDEN is
the program whose --constants prints core/wire/tile_models.cpp and the tables of core/predict
"""
import struct
import subprocess
import sys

from reference_coder import Coder, Models
from reference_mix import mix_tile
from reference_raw import raw_tile
from reference_tables import Bounds, Levels, rays_of, regenerate_table, z_of_count
from reference_tile import depth_tile


def crc32c(data, crc=0):
    crc ^= 0xFFFFFFFF
    for byte in data:
        crc = (crc >> 8) ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


CRC_TABLE = []
for i in range(256):
    for _ in range(8):
        i = (i >> 1) ^ (0x82F63B78 if i & 1 else 0)
    CRC_TABLE.append(i)


class Refused(Exception):
    pass


def need(condition, what):
    if not condition:
        raise Refused(what)


# 2
def packet(data):
    need(len(data) >= 24 and data[0] == 0xC0, "header")
    need(crc32c(data[24:], crc32c(data[:20])) == struct.unpack("<I", data[20:24])[0], "check")
    need(data[1] in (0, 1), "reserved")
    frame = int.from_bytes(data[3:6], "little")
    stamp = int.from_bytes(data[6:12], "little")
    number, count, key_hash = struct.unpack("<HHI", data[12:20])
    return {"key": data[1] == 1, "frame": (data[2], frame, stamp, count, key_hash),
            "slice": number, "hash": key_hash, "body": data[24:]}


# 3
KEY = struct.Struct("<8B I q I 3H 2I 7i Q I H 3I 4i 3q 4i 3q B")
NAMES = ("minor stream flags kind z_rule clock tolerance noise session epoch boot period width height "
         "fx fy cx cy k1 k2 p1 p2 k3 unit lattice offset s bound sigmas "
         "pw px py pz ptx pty ptz aw ax ay az atx aty atz n").split()


def key_packet(body):
    need(len(body) > KEY.size and body[3] < 2, "key body")
    key = dict(zip(NAMES, KEY.unpack(body[:KEY.size])))
    need(key["minor"] == 1 and key["flags"] < 16, "version or flags")
    need(len(body) == KEY.size + key["n"] + 1 and body[-1] == 0, "key length")
    return key


class Stream:
    """What is derived from a key packet."""

    def __init__(self, key, constants):
        self.key = key
        self.width, self.height = key["width"], key["height"]
        self.raw = key["kind"] == 1
        if self.raw:
            return
        self.rays = rays_of(key)
        self.levels = Levels(key)
        self.bounds = Bounds(key, self.rays, self.levels)
        self.start = constants["lossless" if key["tolerance"] == 0 else "bounded"]
        self.activity, self.drift = constants["table"]["activity"], constants["table"]["drift"][0]

    def decode(self, slices):
        hole = (0x7FC00000,) * 3
        pixels = self.width * self.height
        if self.raw:
            cloud = [hole] * pixels
            for body in slices:
                coder = Coder(body)
                raw_tile(self, coder, cloud)
                need(coder.ended(), "trailing or cut")
            return None, cloud
        depth = [0] * pixels
        for body in slices:
            coder = Coder(body)
            tile = mix_tile if self.key["flags"] & 2 else depth_tile
            tile(self, coder, Models(self.start), depth)
            need(coder.ended(), "trailing or cut")
        z = {d: z_of_count(self.key, d) for d in set(depth)}
        point = regenerate_table(self.key)
        cloud = [hole if d == 0 else point(self.rays[i], z[d]) for i, d in enumerate(depth)]
        return depth, cloud


# 12
def records(data):
    need(data[:5] == b"PLC0\0" and data[6:8] == b"\0\0", "file header")
    at = 8
    while True:
        length = struct.unpack("<I", data[at:at + 4])[0]
        if length == 0:
            break
        yield data[at + 4:at + 4 + length]
        at += 4 + length
    count = struct.unpack("<I", data[at + 4:at + 8])[0]
    need(len(data) == at + 8 + 16 * count + 20 and data[-4:] == b"PLCE", "trailer")
    need(crc32c(data[at:-8]) == struct.unpack("<I", data[-8:-4])[0], "index check")


def decode_file(data, constants):
    keys, frames = {}, []
    for record in records(data):
        p = packet(record)
        if p["key"]:
            need(crc32c(p["body"]) == p["hash"], "key hash")
            keys[p["hash"]] = Stream(key_packet(p["body"]), constants)
        else:
            if not frames or frames[-1][0] != p["frame"]:
                frames.append((p["frame"], []))
            frames[-1][1].append(p["body"])
    for frame, bodies in frames:
        need(len(bodies) == frame[3], "slices")
        yield len(bodies), *keys[frame[4]].decode(bodies)


def lines_of(name, folder, constants):
    with open(f"{folder}/{name}.plc", "rb") as file:
        data = file.read()
    for number, (slices, depth, cloud) in enumerate(decode_file(data, constants)):
        counts = "-" if depth is None else f"{crc32c(struct.pack(f'<{len(depth)}H', *depth)):08x}"
        bits = b"".join(struct.pack("<3I", *p) for p in cloud)
        readings = sum(all((w & 0x7F800000) != 0x7F800000 for w in p) for p in cloud)
        yield f"{name} {number} {slices} {readings} {counts} {crc32c(bits):08x}"


def read_constants(program):
    constants = {"lossless": {}, "bounded": {}, "table": {}}
    run = subprocess.run([program, "--constants"], check=True, capture_output=True, text=True)
    for line in run.stdout.splitlines():
        kind, name, *numbers = line.split()
        constants[kind].setdefault(name, []).append([int(n) for n in numbers])
    return constants


def pixels_of(name):
    width, height = name.rsplit("_", 1)[1].split("x")
    return int(width) * int(height)


def main():
    folder, constants = sys.argv[1], read_constants(sys.argv[2])
    most_pixels = int(sys.argv[3]) if len(sys.argv) > 3 else 1 << 30
    with open(f"{folder}/expected.txt", encoding="ascii") as file:
        expected = [line.strip() for line in file if not line.startswith("#")]
    points = [line for line in expected if line.startswith("points_")]
    expected = [line for line in expected if line not in points]
    large = [line for line in expected if pixels_of(line.split()[0]) > most_pixels]
    expected = [line for line in expected if line not in large]
    wrong = 0
    for name in dict.fromkeys(line.split()[0] for line in expected):
        found = list(lines_of(name, folder, constants))
        for line in expected:
            if line.split()[0] == name and line not in found:
                wrong += 1
                print(f"expected {line}\nfound    {found}")
    print(f"{len(expected)} frames, {wrong} differ; {len(points)} of streams of points not covered, "
          f"{len(large)} of over {most_pixels} pixels left out")
    return 1 if wrong or not expected else 0


if __name__ == "__main__":
    sys.exit(main())
