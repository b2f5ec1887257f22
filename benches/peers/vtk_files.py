"""Reads a file with VTK's reader on a clock, or writes it again in another encoding; prints JSON.

Needs `pip install vtk`. A new reader every time, the file in the page cache, the first time not counted. `--none` switches
point arrays off where the reader can (XML); the legacy reader has no such switch.
"""

import argparse
import json
import os
import time

import vtk


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("input")
    parser.add_argument("--none", action="store_true", help="positions and cells only")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--write", metavar="OUT", help="write as the ending of OUT and --mode say instead")
    parser.add_argument("--mode", choices=["ascii", "base64"], default="ascii")
    return parser.parse_args()


def reader_of(path, none):
    if path.endswith(".vtk"):
        reader = vtk.vtkUnstructuredGridReader()
        reader.ReadAllScalarsOn()
        reader.ReadAllVectorsOn()
        reader.ReadAllFieldsOn()
    else:
        reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    if none and not path.endswith(".vtk"):
        reader.UpdateInformation()
        reader.GetPointDataArraySelection().DisableAllArrays()
    return reader


def write(args):
    reader = reader_of(args.input, False)
    if args.write.endswith(".vtk"):
        writer = vtk.vtkUnstructuredGridWriter()
        writer.SetFileTypeToASCII()
    else:
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetCompressorTypeToNone()
        if args.mode == "ascii":
            writer.SetDataModeToAscii()
        else:
            writer.SetDataModeToBinary()
    beside = args.write + ".part"
    writer.SetFileName(beside)
    writer.SetInputConnection(reader.GetOutputPort())
    if writer.Write() != 1:
        raise SystemExit(f"VTK could not write {beside}")
    os.replace(beside, args.write)


def main():
    args = arguments()
    if args.write:
        write(args)
        return
    wall_ms, cpu_ms, points = [], [], 0
    for run in range(args.repeat + 1):
        cpu, wall = time.process_time(), time.perf_counter()
        reader = reader_of(args.input, args.none)
        reader.Update()
        points = reader.GetOutput().GetNumberOfPoints()
        if run > 0:
            wall_ms.append(1e3 * (time.perf_counter() - wall))
            cpu_ms.append(1e3 * (time.process_time() - cpu))
    print(json.dumps({"version": vtk.vtkVersion.GetVTKVersion(), "bytes": os.path.getsize(args.input),
                      "points": points, "wall_ms": wall_ms, "cpu_ms": cpu_ms}))


if __name__ == "__main__":
    main()
