// Every public header, for check_inline.py: what it defines, other files may define too.
#include <holdfast/holdfast.hpp>
#ifdef WITH_CALIBRATION
#include <holdfast/calibration/filter_tuning.hpp>
#endif
#ifdef WITH_IO
#include <holdfast/io/io.hpp>
#endif
#ifdef WITH_RENDERING
#include <holdfast/rendering/rendering.hpp>
#endif
#ifdef WITH_SCENE
#include <holdfast/scene/scene.hpp>
#endif
#ifdef WITH_GLM
#include <holdfast/interop/glm.hpp>
#endif
#ifdef WITH_OPENXR
#include <holdfast/interop/openxr.hpp>
#endif
