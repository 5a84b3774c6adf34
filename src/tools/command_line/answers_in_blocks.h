#pragma once

#include <exception>
#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tools/command_line/answers_in_order.h"

namespace proximity_server::tools {

/// A stream of things to answer, which go to the threads in blocks of one size. What answers a block knows nothing of
/// the one before: so the answers are the same, bit by bit, for any number of threads, which warm starts kept across
/// blocks would change in the last digits.
template <typename Item, typename Answer>
struct BlockWork {
  std::size_t block_size = 1;
  std::function<bool(Item&)> next;  ///< reads one, in the calling thread; false at the end
  std::function<std::vector<Answer>(const std::vector<Item>&)> answer;  ///< of one block, in any thread
  std::function<void(const Answer&)> take;                              ///< in order, in the calling thread
};

/// Reads blocks; an error of reading ends them, and is kept for later.
template <typename Item>
class BlockReader {
 public:
  BlockReader(std::size_t block_size, std::function<bool(Item&)> next)
      : block_size_(block_size), next_(std::move(next)) {}

  /// Empty at the end.
  std::vector<Item> block() {
    std::vector<Item> items;
    try {
      for (Item item; items.size() < block_size_ && !error_ && next_(item);) items.push_back(item);
    } catch (const std::invalid_argument&) {
      error_ = std::current_exception();
    }
    return items;
  }

  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::size_t block_size_;
  std::function<bool(Item&)> next_;
  std::exception_ptr error_;
};

/// Does the work. At most threads + 1 blocks are in memory.
/// Failure: what reading threw, after the answers to all before it were taken.
template <typename Item, typename Answer>
void answerInBlocks(const BlockWork<Item, Answer>& work, int threads) {
  BlockReader<Item> reader(work.block_size, work.next);
  AnswersInOrder<std::vector<Answer>> answers(threads, [&](const std::vector<Answer>& block) {
    for (const Answer& answer : block) work.take(answer);
  });
  for (std::vector<Item> block = reader.block(); !block.empty(); block = reader.block()) {
    answers.start([&work, items = std::move(block)] { return work.answer(items); });
  }
  answers.finish();
  reader.rethrow();
}

}  // namespace proximity_server::tools
