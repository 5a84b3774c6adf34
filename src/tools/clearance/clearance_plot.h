#pragma once

#include <fstream>
#include <string>

namespace proximity_server::tools {

/// A picture of the rows of `clearance`, drawn by clearance_plot.py, which stands beside the executable.
class ClearancePlot {
 public:
  /// The suffix of the name determines the format: .png, .pdf or .svg.
  ///
  /// Failure: throws std::invalid_argument for another suffix, if the file cannot be written, if the script is missing,
  ///          and if matplotlib is not installed, so that nobody waits for a picture that cannot be drawn.
  explicit ClearancePlot(std::string picture);
  ~ClearancePlot();
  ClearancePlot(const ClearancePlot&) = delete;
  ClearancePlot& operator=(const ClearancePlot&) = delete;

  /// Takes the rows as CSV.
  std::ostream& data() { return data_; }

  /// Draws the picture with a line at `limit` [m]. Throws std::invalid_argument naming the picture if drawing fails.
  void draw(double limit);

 private:
  std::string picture_, format_, script_, data_path_;
  std::ofstream data_;
};

}  // namespace proximity_server::tools
