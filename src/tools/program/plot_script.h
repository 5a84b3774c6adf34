#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace proximity_server::tools {

/// A picture that a Python script with matplotlib draws of the data that a tool writes. The script stands beside the
/// executable. It is called without arguments to see whether it can draw, else as
///   script DATA PICTURE FORMAT [more arguments].
class PlotScript {
 public:
  /// The suffix of the picture's name determines the format: .png, .pdf or .svg.
  ///
  /// Failure: throws std::invalid_argument for another suffix, if the file cannot be written, if the script is missing,
  ///          and if matplotlib is not installed, so that nobody waits for a picture that cannot be drawn.
  PlotScript(const std::string& script, std::string picture);
  ~PlotScript();
  PlotScript(const PlotScript&) = delete;
  PlotScript& operator=(const PlotScript&) = delete;

  /// Takes the data.
  std::ostream& data() { return data_; }

  /// Draws the picture. Throws std::invalid_argument naming the picture if drawing fails.
  void draw(const std::vector<std::string>& more_arguments = {});

 private:
  std::string picture_, format_, script_, data_path_;
  std::ofstream data_;
};

}  // namespace proximity_server::tools
