"""Draws a .vtu with VTK's fluid mapper, off screen, and prints as JSON what each frame cost: the peer that meniscus is measured by.

Needs `pip install vtk`. Camera as in `meniscus render --camera`; the camera orbits half a degree a frame, as in
`meniscus bench`. Process CPU time (user + system, all threads) and wall time, each frame waited for; the first picture, with
compilation and set-up, is not counted.
"""

import argparse
import json
import time

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

# In the order of a cube map's faces.
FACES = ["px", "nx", "py", "ny", "pz", "nz"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("input")
    parser.add_argument("output", help="PNG of the first view")
    parser.add_argument("--radius", type=float, required=True)
    parser.add_argument("--camera", required=True, help="ex,ey,ez/tx,ty,tz/ux,uy,uz/fovy")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--attenuation-scale", type=float, default=1.0, help="1 / depth of the water, for clear water")
    parser.add_argument("--look", choices=["default", "tuned", "best"], default="tuned",
                        help="the mapper's own colours and refraction, those that look most like water, "
                             "or these with a wider filter as well, whatever it costs")
    parser.add_argument("--surroundings", metavar="FOLDER",
                        help="background.png, and what is reflected: " + ", ".join(f"{face}.png" for face in FACES))
    parser.add_argument("--sun", help="x,y,z towards a lamp in place of the one at the camera")
    parser.add_argument("--ground", metavar="FILE",
                        help="ESRI ASCII grid that the water stands on; looks as in background.png")
    parser.add_argument("--normals", metavar="FILE",
                        help="write the filtered surface's unit normals in view space, three 32-bit floats a pixel, row by row from "
                             "the top left; 0 where there is no surface")
    return parser.parse_args()


def near_the_origin(points, eye, target):
    """The points as VTK draws them best: relative to the target, and those far from the eye first.

    VTK hands 32-bit coordinates to the GPU: of a map's, they keep a quarter of a metre. And the mapper's own depth test has no
    effect in VTK 9.7.2 on llvmpipe: of the spheres at a pixel, the one drawn last is seen.
    """
    positions = vtk_to_numpy(points.GetData()) - numpy.array(target)
    order = numpy.argsort(-((positions - numpy.subtract(eye, target)) ** 2).sum(axis=1))
    moved = vtk.vtkPoints()
    moved.SetData(numpy_to_vtk(positions[order].astype(numpy.float32), deep=True))
    return moved


def image(path):
    reader = vtk.vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def turned(picture):
    """Turned by 180 degrees: the faces of a cube map are seen from outside, and their first row is on top."""
    for axis in [0, 1]:
        flip = vtk.vtkImageFlip()
        flip.SetFilteredAxis(axis)
        flip.SetInputData(picture)
        flip.Update()
        picture = flip.GetOutput()
    return picture


def surround(renderer, folder):
    """Behind the water the background, which it refracts; in it the reflection of the cube's faces."""
    background = vtk.vtkTexture()
    background.SetInputData(image(f"{folder}/background.png"))
    background.InterpolateOn()
    renderer.TexturedBackgroundOn()
    renderer.SetBackgroundTexture(background)

    cube = vtk.vtkTexture()
    cube.CubeMapOn()
    cube.InterpolateOn()
    cube.MipmapOn()
    for index, face in enumerate(FACES):
        cube.SetInputDataObject(index, turned(image(f"{folder}/{face}.png")))
    renderer.SetEnvironmentTexture(cube)
    renderer.UseImageBasedLightingOn()
    renderer.UseSphericalHarmonicsOff()
    # The mapper looks up the sharpest level only; the others, and the light on rough things, take minutes without a GPU.
    renderer.GetEnvMapPrefiltered().SetPrefilterLevels(1)
    renderer.GetEnvMapPrefiltered().SetPrefilterMaxSamples(1)
    renderer.GetEnvMapLookupTable().SetLUTSize(2)
    renderer.GetEnvMapLookupTable().SetLUTSamples(1)
    renderer.GetEnvMapIrradiance().SetIrradianceSize(2)


def ground(path, target, camera, size, picture):
    """The grid as an actor that shows what `picture` has where it is seen: so it covers the water that it should, and no light of VTK's
    changes it."""
    with open(path) as file:
        words = file.read().split()
    header = {words[i].lower(): float(words[i + 1]) for i in range(0, 10, 2)}
    columns, rows, cell = int(header["ncols"]), int(header["nrows"]), header["cellsize"]
    z = numpy.array(words[10:], dtype=float).reshape(rows, columns)[::-1]
    x = header["xllcenter"] + cell * numpy.arange(columns)
    y = header["yllcenter"] + cell * numpy.arange(rows)
    places = numpy.stack([*numpy.meshgrid(x, y), z], axis=-1).reshape(-1, 3) - numpy.array(target)

    matrix = camera.GetCompositeProjectionTransformMatrix(size[0] / size[1], 0, 1)
    rows_of = numpy.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    clip = numpy.c_[places, numpy.ones(len(places))] @ rows_of.T
    in_front = clip[:, 3] > 0
    seen = numpy.where(in_front[:, None], 0.5 + 0.5 * clip[:, :2] / numpy.maximum(clip[:, 3:], 1e-9), 0)

    corner = (numpy.arange(rows - 1)[:, None] * columns + numpy.arange(columns - 1)).ravel()
    squares = numpy.stack([corner, corner + 1, corner + columns + 1, corner + columns], axis=1)
    squares = squares[in_front[squares].all(axis=1)]
    cells = vtk.vtkCellArray()
    offsets = numpy.arange(0, 4 * len(squares) + 1, 4)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(squares.ravel(), deep=True))
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(places.astype(numpy.float32), deep=True))
    surface = vtk.vtkPolyData()
    surface.SetPoints(points)
    surface.SetPolys(cells)
    surface.GetPointData().SetTCoords(numpy_to_vtk(seen.astype(numpy.float32), deep=True))
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(surface)
    texture = vtk.vtkTexture()
    texture.SetInputData(image(picture))
    texture.InterpolateOn()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.SetTexture(texture)
    actor.GetProperty().LightingOff()
    return actor


def pixels(window):
    """The picture as numbers from 0 to 1, row by row from the bottom left."""
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    width, height, _ = grab.GetOutput().GetDimensions()
    return vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).reshape(height, width, 3) / 255.0


def view_normals(window, renderer, mapper):
    """The normals of the surface.

    The mapper writes them as they are, and of colours only what lies between 0 and 1 is left: so a second picture is taken upside
    down, in which what was negative in x and y is positive.
    """
    mapper.SetDisplayMode(vtk.vtkOpenGLFluidMapper.FilteredSurfaceNormal)
    renderer.TexturedBackgroundOff()
    renderer.SetBackground(0, 0, 0)
    window.Render()
    upright = pixels(window)
    renderer.GetActiveCamera().Roll(180)
    window.Render()
    rolled = pixels(window)[::-1, ::-1]
    renderer.GetActiveCamera().Roll(180)
    normals = upright - rolled
    normals[..., 2] = numpy.maximum(upright[..., 2], rolled[..., 2])
    return normals


def main():
    args = arguments()
    eye, target, up, fovy = args.camera.split("/")
    vector = lambda text: [float(number) for number in text.split(",")]
    eye, target = vector(eye), vector(target)

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(args.input)
    reader.Update()
    particles = vtk.vtkPolyData()
    particles.SetPoints(near_the_origin(reader.GetOutput().GetPoints(), eye, target))

    mapper = vtk.vtkOpenGLFluidMapper()
    mapper.SetInputData(particles)
    mapper.SetParticleRadius(args.radius)
    mapper.SetDisplayMode(vtk.vtkOpenGLFluidMapper.TransparentFluidVolume)
    mapper.SetAttenuationScale(args.attenuation_scale)
    if args.look == "tuned":
        mapper.SetAttenuationColor(0.8, 0.2, 0.15)
        mapper.SetRefractionScale(0.07)
    if args.look == "best":
        mapper.SetAttenuationColor(0.75, 0.16, 0.09)
        mapper.SetRefractionScale(0.07)
        mapper.SetSurfaceFilterIterations(5)
        mapper.SetSurfaceFilterRadius(10)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0.7, 0.8, 0.9)
    renderer.AddVolume(volume)
    if args.surroundings:
        surround(renderer, args.surroundings)
    if args.sun:
        lamp = vtk.vtkLight()
        lamp.SetLightTypeToSceneLight()
        lamp.PositionalOff()
        lamp.SetFocalPoint(0, 0, 0)
        lamp.SetPosition(*vector(args.sun))
        renderer.AddLight(lamp)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*[at - to for at, to in zip(eye, target)])
    camera.SetFocalPoint(0, 0, 0)
    camera.SetViewUp(*vector(up))
    camera.SetViewAngle(float(fovy))
    size = [int(side) for side in args.size.split("x")]
    if args.ground:
        renderer.AddActor(ground(args.ground, target, camera, size, f"{args.surroundings}/background.png"))
    renderer.ResetCameraClippingRange()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*size)
    window.SetMultiSamples(0)
    window.AddRenderer(renderer)
    window.Render()

    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(args.output)
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()

    if args.normals:
        view_normals(window, renderer, mapper)[::-1].astype("<f4").tofile(args.normals)

    wall_ms, cpu_ms = [], []
    for _ in range(args.frames):
        cpu, wall = time.process_time(), time.perf_counter()
        camera.Azimuth(0.5)
        window.Render()
        window.WaitForCompletion()
        wall_ms.append(1e3 * (time.perf_counter() - wall))
        cpu_ms.append(1e3 * (time.process_time() - cpu))
    print(json.dumps({"version": vtk.vtkVersion.GetVTKVersion(), "wall_ms": wall_ms, "cpu_ms": cpu_ms}))


if __name__ == "__main__":
    main()
