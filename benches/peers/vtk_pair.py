"""Two pictures of the same size side by side, each with its caption, as a small JPEG.

Needs `pip install vtk`.
"""

import argparse

import vtk

GAP_PX = 4


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("left", help="PNG")
    parser.add_argument("right", help="PNG")
    parser.add_argument("output", help="JPEG")
    parser.add_argument("--captions", nargs=2, required=True)
    parser.add_argument("--width", type=int, default=800, help="of each, in pixels")
    parser.add_argument("--quality", type=int, default=85)
    return parser.parse_args()


def resized(path, width):
    """The picture of a file, `width` pixels wide, and its height."""
    reader = vtk.vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    columns, rows, _ = reader.GetOutput().GetDimensions()
    height = round(rows * width / columns)
    sinc = vtk.vtkImageSincInterpolator()
    sinc.AntialiasingOn()
    resize = vtk.vtkImageResize()
    resize.SetInputData(reader.GetOutput())
    resize.SetOutputDimensions(width, height, 1)
    resize.SetInterpolator(sinc)
    resize.Update()
    return resize.GetOutput(), height


def half(picture, caption, left, right):
    """A renderer of this part of the window that shows the picture, with the caption in its corner."""
    texture = vtk.vtkTexture()
    texture.SetInputData(picture)
    renderer = vtk.vtkRenderer()
    renderer.SetViewport(left, 0, right, 1)
    renderer.TexturedBackgroundOn()
    renderer.SetBackgroundTexture(texture)
    text = vtk.vtkTextActor()
    text.SetInput(caption)
    text.GetTextProperty().SetFontSize(18)
    text.GetTextProperty().SetColor(0, 0, 0)
    text.SetPosition(10, 10)
    renderer.AddViewProp(text)
    return renderer


def main():
    args = arguments()
    (left, height), (right, _) = [resized(path, args.width) for path in [args.left, args.right]]
    whole = 2 * args.width + GAP_PX
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(whole, height)
    behind = vtk.vtkRenderer()
    behind.SetBackground(1, 1, 1)
    window.AddRenderer(behind)
    window.AddRenderer(half(left, args.captions[0], 0, args.width / whole))
    window.AddRenderer(half(right, args.captions[1], 1 - args.width / whole, 1))
    window.Render()

    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    writer = vtk.vtkJPEGWriter()
    writer.SetFileName(args.output)
    writer.SetQuality(args.quality)
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()


if __name__ == "__main__":
    main()
