# holdfast::rendering: filled with the GL context.
