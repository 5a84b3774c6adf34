#pragma once

#include "python/robot.h"

#include <pybind11/pybind11.h>

namespace proximity_server::python {

/// Declares the questions as methods of the class `Robot` of the module. Their docstrings document results and errors.
///
/// Many Python threads may ask questions at once. A question releases the GIL while it computes, and each of its
/// threads borrows a scratch. Ctrl-C ends a question, and so does the end of its time budget: what is not answered by
/// then is unknown.
void declareQuestions(pybind11::class_<Robot>& robot);

}  // namespace proximity_server::python
