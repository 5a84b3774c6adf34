#pragma once

#include "system/whole_file.h"

#include <fstream>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// The option that names the picture, the script, and the suffixes that the name of the picture may have.
struct PlotKind {
  std::string option, script;
  std::vector<std::string> suffixes{".png", ".pdf", ".svg"};
};

/// A picture that a Python script with matplotlib draws of the data that a tool writes. The script stands beside the
/// executable. It is called without arguments to see whether it can draw, else as
///   script DATA FORMAT [more arguments] > PICTURE.
class PlotScript {
 public:
  /// The suffix of the picture's name determines the format.
  ///
  /// Failure: throws std::invalid_argument for another suffix, if the file cannot be written, if the script is missing,
  ///          and if matplotlib is not installed, so that nobody waits for a picture that cannot be drawn.
  PlotScript(const PlotKind& kind, const std::string& picture);
  ~PlotScript();
  PlotScript(const PlotScript&) = delete;
  PlotScript& operator=(const PlotScript&) = delete;

  /// Takes the data.
  std::ostream& data() { return data_; }

  /// Draws the picture. Throws std::invalid_argument naming the picture if drawing fails.
  void draw(const std::vector<std::string>& more_arguments = {});

 private:
  std::string option_, format_, script_, data_path_;
  system::WholeFile picture_;
  std::ofstream data_;
};

}  // namespace proximity_server::tools
