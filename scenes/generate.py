#!/usr/bin/env python3
"""Writes the procedural scenes of Regulus: scenes/<name>/<name>.gltf and .bin (scenes/README.md says what
each shows). Deterministic: the files in the repository are the output of this program, byte for byte."""
import argparse
import pathlib
import sys

sys.dont_write_bytecode = True  # leaves no cache in the source tree
from generator import ajar, bazaar, big, cornell, furnace, gallery, lamp, mirrors, outdoors, plates, pool, ring, smallvcm, street, sunlit_room, watch  # noqa: E402

SCENES = {"cornell": cornell, "plates": plates, "mirrors": mirrors, "furnace": furnace,
          "watch": watch, "ring": ring, "pool": pool, "lamp": lamp, "smallvcm": smallvcm, "gallery": gallery,
          "outdoors": outdoors, "street": street, "ajar": ajar,
          "sunlit-room": sunlit_room}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"scenes to write: {', '.join(SCENES)} (all)")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent,
                        help="folder that gets one folder per scene (where this program is)")
    parser.add_argument("--big", type=pathlib.Path, metavar="OUT.glb",
                        help="write only the benchmark scene of a million triangles, to this file")
    parser.add_argument("--bazaar", type=pathlib.Path, metavar="OUT.glb",
                        help="write only the benchmark scene of a hundred thousand emitters, to this file")
    parser.add_argument("--lit", type=int, default=100000, help="how many of them emit; 0: one other triangle (100000)")
    arguments = parser.parse_args()
    if arguments.big:
        big.build().write_glb(arguments.big)
        return
    if arguments.bazaar:
        bazaar.build(arguments.lit).write_glb(arguments.bazaar)
        return
    unknown = [name for name in arguments.names if name not in SCENES]
    if unknown:
        parser.error(f"no scene {unknown[0]}; there are {', '.join(SCENES)}")
    for name in arguments.names or SCENES:
        for stem, scene in SCENES[name].build().items():
            scene.write(arguments.out / name / stem)


if __name__ == "__main__":
    main()
