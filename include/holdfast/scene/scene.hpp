/// Everything of holdfast::scene: models from files, drawn.
#pragma once

#include <holdfast/scene/jpeg.hpp>
#include <holdfast/scene/load_model.hpp>
#include <holdfast/scene/model.hpp>
#include <holdfast/scene/model_painter.hpp>
#include <holdfast/scene/texture_image.hpp>
#include <holdfast/scene/tga.hpp>
