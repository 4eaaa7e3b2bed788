// HTTP over a plain loopback socket, so that tests can also send invalid requests.
#pragma once

#include <string>
#include <string_view>

namespace sweepstake::test_support {

// A connection that the destructor closes. If the server sends nothing for a minute, the test
// program ends.
class HttpSocket {
 public:
  // `receive_bytes` limits the receive buffer, so that the system accepts little unread data.
  explicit HttpSocket(int port, int receive_bytes = 0);
  ~HttpSocket();
  HttpSocket(const HttpSocket&) = delete;
  HttpSocket& operator=(const HttpSocket&) = delete;

  void Send(std::string_view bytes);
  // Closes the sending side.
  void HalfClose();
  // Closes the connection with a reset instead of an orderly end.
  void Reset();
  // Returns all data until the server closes the connection.
  std::string ReadAll();
  // Returns one answer with a Content-Length.
  std::string ReadAnswer();
  // Returns the data up to the text, or all data if the server closes the connection before.
  std::string ReadUntil(std::string_view text);
  // Waits until the server ends the connection. Returns whether it ended with a reset.
  bool WasReset();

 private:
  // Returns false at the end of the connection.
  bool ReadMore();

  int socket_;
  std::string unread_;
};

struct HttpAnswer {
  int status = 0;
  std::string head;
  std::string body;
};

// Sends `request` and reads until the server closes the connection.
HttpAnswer Exchange(int port, std::string_view request);

// Returns the content of the chunks of a body.
std::string Dechunked(std::string body);

// Gets a page.
HttpAnswer Get(int port, const std::string& target);

}  // namespace sweepstake::test_support
