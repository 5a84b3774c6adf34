#pragma once

#include <exception>
#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tools/command_line/answers_in_order.h"

namespace proximity_server::tools {

/// A stream of items, which are answered by several threads in blocks of one size. The answers about a block do not
/// depend on other blocks, so they have the same bits for any number of threads; warm starts that were kept from one
/// block to the next would change the last digits.
template <typename Item, typename Answer>
struct BlockWork {
  std::size_t block_size = 1;
  std::function<bool(Item&)> next;  ///< reads one item in the calling thread; false at the end
  std::function<std::vector<Answer>(const std::vector<Item>&)> answer;  ///< answers about one block, in any thread
  std::function<void(const Answer&)> handle;  ///< gets the answers in order, in the calling thread
};

/// Reads blocks of items. An error of reading ends the blocks, and rethrow() throws it.
template <typename Item>
class BlockReader {
 public:
  BlockReader(std::size_t block_size, std::function<bool(Item&)> next)
      : block_size_(block_size), next_(std::move(next)) {}

  /// The next block; empty at the end.
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

/// Reads all items, answers them and handles the answers. At most threads + 1 blocks are in memory.
/// Failure: throws the error of reading, after the answers about all items before it were handled.
template <typename Item, typename Answer>
void answerInBlocks(const BlockWork<Item, Answer>& work, int threads) {
  BlockReader<Item> reader(work.block_size, work.next);
  AnswersInOrder<std::vector<Answer>> answers(threads, [&](const std::vector<Answer>& block) {
    for (const Answer& answer : block) work.handle(answer);
  });
  for (std::vector<Item> block = reader.block(); !block.empty(); block = reader.block()) {
    answers.start([&work, items = std::move(block)] { return work.answer(items); });
  }
  answers.finish();
  reader.rethrow();
}

}  // namespace proximity_server::tools
