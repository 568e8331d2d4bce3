/// Frames: the coordinate-system graph, its histories, the display chain, navigation and explanation. Includes the
/// whole folder.
#pragma once

#include <holdfast/frames/chain.hpp>
#include <holdfast/frames/display_chain.hpp>
#include <holdfast/frames/explain.hpp>
#include <holdfast/frames/graph.hpp>
#include <holdfast/frames/graphviz.hpp>
#include <holdfast/frames/lookup.hpp>
#include <holdfast/frames/navigation.hpp>
#include <holdfast/frames/pose_history.hpp>
