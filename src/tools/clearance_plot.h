#pragma once

#include <fstream>
#include <string>

namespace proximity_server {

/// A picture of the rows of `clearance`, drawn by clearance_plot.py, which stands beside the executable.
class ClearancePlot {
 public:
  /// Failure: throws std::invalid_argument where the script is missing or matplotlib is not installed, so that nobody
  /// waits for a picture that cannot be drawn.
  explicit ClearancePlot(std::string png);
  ~ClearancePlot();
  ClearancePlot(const ClearancePlot&) = delete;
  ClearancePlot& operator=(const ClearancePlot&) = delete;

  /// Takes the rows as CSV.
  std::ostream& data() { return data_; }

  /// `limit` [m] is the clearance that a line marks. Throws std::invalid_argument naming the picture where drawing
  /// fails.
  void draw(double limit);

 private:
  std::string png_, script_, data_path_;
  std::ofstream data_;
};

}  // namespace proximity_server
