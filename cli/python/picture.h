#pragma once
#include <pybind11/pybind11.h>

#include <memory>

#include "cli/python/character.h"
#include "cli/python/rig.h"

namespace backbend::python {

/// Character.render(): a picture of a pose as arrays. Throws TypeError, ValueError; RenderError;
/// RigError.
py::object rendered(const std::shared_ptr<const Character>& character, const Rig& rig,
                    const std::string& mapping, const std::string& view, int width, int height,
                    int samples, const std::string& mode, std::uint32_t seed, bool all_layers,
                    bool transparent, bool denoise, py::handle heat, const py::kwargs& channels);

}  // namespace backbend::python
