#!/usr/bin/env python3
"""Gives files of a run that a test has changed the checksums of their bytes (src/io/run/FORMAT.md).

usage: seal.py RUN.json [FILE ...]     FILE: of its directory, as long as before or cut, and in checksums.csv
"""
import json
import os
import re
import sys

MASK = (1 << 64) - 1
SEED, CHAIN_SEED, PRIME = 0x9E3779B97F4A7C15, 0xCBF29CE484222325, 0x100000001B3


def mix(value):
    value ^= value >> 30
    value = value * 0xBF58476D1CE4E5B9 & MASK
    value ^= value >> 27
    value = value * 0x94D049BB133111EB & MASK
    return value ^ value >> 31


def hash_bytes(data, value=SEED):
    """As checksums.csv has it: whole words of 8 bytes, little endian, then single bytes."""
    whole = len(data) - len(data) % 8
    for at in range(0, whole, 8):
        value = mix(value ^ int.from_bytes(data[at:at + 8], "little")) * PRIME & MASK
    for byte in data[whole:]:
        value = (value ^ byte) * PRIME & MASK
    return value


def seal_files(directory, names):
    """Gives the pieces of files their hashes; the "bytes" and the "chain" of checksums.csv then."""
    path = os.path.join(directory, "checksums.csv")
    contents = {name: open(os.path.join(directory, name), "rb").read() for name in names}
    heading, *lines = open(path, encoding="utf-8").read().splitlines(keepends=True)
    chain, text = hash_bytes(heading.encode(), CHAIN_SEED), heading
    for line in lines:
        name, frame, begin, end, sum_, _ = line.split(",")
        if name in contents:
            if int(end) > len(contents[name]):
                continue
            sum_ = "%016x" % hash_bytes(contents[name][int(begin):int(end)])
        line = ",".join([name, frame, begin, end, sum_, ""])
        chain = hash_bytes(line.encode(), chain)
        text += line + "%016x\n" % chain
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return {"bytes": len(text), "chain": "%016x" % chain}


def main():
    path = sys.argv[1]
    with open(path, "rb") as file:
        text = file.read()
    if sys.argv[2:]:
        record = json.loads(text)
        record["checksums"].update(seal_files(os.path.dirname(path), sys.argv[2:]))
        text = json.dumps(record, indent=2).encode()
    body = re.sub(rb',?\s*("checksum": "[0-9a-f]*")?\s*}\s*$', b"", text)
    with open(path, "wb") as file:
        file.write(body + b',\n  "checksum": "%016x"\n}\n' % hash_bytes(body))


if __name__ == "__main__":
    main()
