// An HTTP server on a loopback port that records the requests and gives scripted answers.
#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sweepstake::alerts {

class WebhookReceiver {
 public:
  struct Request {
    std::string method;
    std::string target;
    std::string content_type;
    std::string user_agent;
    std::string body;
  };
  // An answer with this status closes the connection without an answer.
  static constexpr int kNoAnswer = 0;

  WebhookReceiver() : thread_([this] { Serve(); }) {
    setenv("no_proxy", "127.0.0.1", 1);  // libcurl would use a proxy of the environment
  }
  ~WebhookReceiver() {
    closing_ = true;
    boost::system::error_code ignored;
    Tcp::socket wake(io_);
    wake.connect(acceptor_.local_endpoint(), ignored);  // ends the pending accept
    thread_.join();
  }

  int port() const { return acceptor_.local_endpoint().port(); }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port()) + "/alerts?a=b"; }

  // Sets the statuses of the next answers; later answers have 204. A redirect leads to this server.
  void AnswerWith(std::deque<int> statuses) {
    const std::lock_guard lock(mutex_);
    statuses_ = std::move(statuses);
  }
  // Waits until `count` requests have arrived, and returns all of them.
  std::vector<Request> Await(size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return requests_.size() >= count; });
    return requests_;
  }
  size_t request_count() {
    const std::lock_guard lock(mutex_);
    return requests_.size();
  }

 private:
  using Tcp = boost::asio::ip::tcp;

  void Serve() {
    while (true) {
      Tcp::socket socket(io_);
      acceptor_.accept(socket);
      if (closing_) return;
      Answer(socket);
    }
  }
  void Answer(Tcp::socket& socket) {
    namespace http = boost::beast::http;
    boost::beast::flat_buffer buffer;
    http::request<http::string_body> request;
    boost::system::error_code error;
    http::read(socket, buffer, request, error);
    if (error) return;
    int status = 204;
    {
      const std::lock_guard lock(mutex_);
      requests_.push_back({.method = std::string(request.method_string()),
                           .target = std::string(request.target()),
                           .content_type = std::string(request[http::field::content_type]),
                           .user_agent = std::string(request[http::field::user_agent]),
                           .body = request.body()});
      if (!statuses_.empty()) {
        status = statuses_.front();
        statuses_.pop_front();
      }
    }
    changed_.notify_all();
    if (status == kNoAnswer) return;
    http::response<http::string_body> response(static_cast<http::status>(status), 11);
    if (status / 100 == 3) response.set(http::field::location, url());
    response.keep_alive(false);
    response.prepare_payload();
    http::write(socket, response, error);
  }

  boost::asio::io_context io_;
  Tcp::acceptor acceptor_{io_, Tcp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0)};
  std::atomic<bool> closing_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<int> statuses_;       // guarded by mutex_
  std::vector<Request> requests_;  // guarded by mutex_
  std::thread thread_;             // last: it uses the members above
};

}  // namespace sweepstake::alerts
