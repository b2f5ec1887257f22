"""Draws a .vtu with VTK's fluid mapper, off screen, and prints as JSON what each frame cost: the peer that meniscus is measured by.

Needs `pip install vtk`. Camera as in `meniscus render --camera`; the camera orbits half a degree a frame, as in
`meniscus bench`. Process CPU time (user + system, all threads) and wall time, each frame waited for; the first picture, with
compilation and set-up, is not counted.
"""

import argparse
import json
import time

import vtk


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("input")
    parser.add_argument("output", help="PNG of the first view")
    parser.add_argument("--radius", type=float, required=True)
    parser.add_argument("--camera", required=True, help="ex,ey,ez/tx,ty,tz/ux,uy,uz/fovy")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--attenuation-scale", type=float, default=1.0, help="1 / depth of the water, for clear water")
    parser.add_argument("--look", choices=["default", "tuned"], default="tuned",
                        help="the mapper's own colours and refraction, or those that look most like water")
    return parser.parse_args()


def main():
    args = arguments()
    eye, target, up, fovy = args.camera.split("/")
    vector = lambda text: [float(number) for number in text.split(",")]

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(args.input)
    reader.Update()
    particles = vtk.vtkPolyData()
    particles.SetPoints(reader.GetOutput().GetPoints())

    mapper = vtk.vtkOpenGLFluidMapper()
    mapper.SetInputData(particles)
    mapper.SetParticleRadius(args.radius)
    mapper.SetDisplayMode(vtk.vtkOpenGLFluidMapper.TransparentFluidVolume)
    mapper.SetAttenuationScale(args.attenuation_scale)
    if args.look == "tuned":
        mapper.SetAttenuationColor(0.8, 0.2, 0.15)
        mapper.SetRefractionScale(0.07)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0.7, 0.8, 0.9)
    renderer.AddVolume(volume)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*vector(eye))
    camera.SetFocalPoint(*vector(target))
    camera.SetViewUp(*vector(up))
    camera.SetViewAngle(float(fovy))
    renderer.ResetCameraClippingRange()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*[int(side) for side in args.size.split("x")])
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
