using System;
using System.IO;
using System.Net;
using System.Security.Cryptography;
using System.Security.Cryptography.X509Certificates;
using NUnit.Framework;
using Sweepstake.Editor;
using Sweepstake.GrpcNet;

namespace Sweepstake.Tests
{
    /// <summary>Tests TLS with a private authority, client certificates and tokens, with a real daemon.</summary>
    public sealed class SecurityTest
    {
        private string folder;

        [SetUp]
        public void MakeFolder()
        {
            folder = Directory.CreateTempSubdirectory("sweepstake_tls").FullName;
        }

        [TearDown]
        public void RemoveFolder()
        {
            Directory.Delete(folder, true);
        }

        [Test]
        public void APrivateAuthorityIsTrustedAndAnotherOneIsNot([Values] bool withRsa)
        {
            using var authority = new TestAuthority(folder, "ours", withRsa);
            using var stranger = new TestAuthority(folder, "theirs", withRsa);
            authority.Issue("daemon");
            using var daemon = new DaemonProcess("--tls-cert", PathOf("daemon.pem"), "--tls-key", PathOf("daemon.key"));
            using (Game game = Game.At(daemon.Address, PrivateTls.With(authority.File)))
                game.PlayUntilOnline();
            using (Game game = Game.At(daemon.Address, PrivateTls.With(stranger.File)))
                AssertNeverOnline(game);
            using (Game game = Game.At(daemon.Address, endpoint => endpoint.UsesTls = true))
                AssertNeverOnline(game);
        }

        [Test]
        public void ACertificateForAnotherHostIsNotTrusted()
        {
            using var authority = new TestAuthority(folder, "ours", false);
            authority.Issue("daemon", "elsewhere.example", IPAddress.Parse("127.0.0.9"));
            using var daemon = new DaemonProcess("--tls-cert", PathOf("daemon.pem"), "--tls-key", PathOf("daemon.key"));
            using Game game = Game.At(daemon.Address, PrivateTls.With(authority.File));
            AssertNeverOnline(game);
        }

        [Test]
        public void ADaemonMayAskForTheGamesCertificate([Values] bool withRsa)
        {
            using var authority = new TestAuthority(folder, "ours", withRsa);
            authority.Issue("daemon");
            authority.Issue("game");
            using var daemon = new DaemonProcess(
                "--tls-cert", PathOf("daemon.pem"), "--tls-key", PathOf("daemon.key"), "--tls-client-ca", authority.File);
            using (Game game = Game.At(daemon.Address, PrivateTls.With(authority.File, PathOf("game.pem"), PathOf("game.key"))))
                game.PlayUntilOnline();
            using (Game game = Game.At(daemon.Address, PrivateTls.With(authority.File)))
                AssertNeverOnline(game);
        }

        [Test]
        public void TheRightTokenLetsInAndAWrongOneIsRefusedWithTheReason()
        {
            string token = null;
            using var daemon = new DaemonProcess(
                made => token = made.Run("token", "create", "arcade", "--role", "ingest"), new[] { "--require-tokens" });
            string file = PathOf("token");
            File.WriteAllText(file, token + "\n");
            using (Game game = Game.At(daemon.Address, endpoint => endpoint.TokenFile = file))
                game.PlayUntilOnline();
            using (Game game = Game.At(daemon.Address, endpoint => endpoint.Token = "swt_wrong"))
            {
                game.PlayUntil(() => game.Status.Refusal.Length > 0, "refused");
                Assert.That(game.Status.Refusal, Does.Contain("token"));
                Assert.That(game.Status.Refusal, Does.Not.Contain("swt_wrong"));
            }
            using (Game game = Game.At(daemon.Address))
                game.PlayUntil(() => game.Status.Refusal.Length > 0, "refused");
        }

        [Test]
        public void WhatIsWrongWithAnEndpointIsSaidAtOnce()
        {
            AssertWrong(new DaemonEndpoint { Address = "daemon" }, "HOST:PORT");
            AssertWrong(new DaemonEndpoint { Address = "host:1/path" }, "HOST:PORT");
            AssertWrong(new DaemonEndpoint { Token = "t", TokenFile = "f" }, "not both");
            AssertWrong(new DaemonEndpoint { Token = "two words" }, "is not a token");
            AssertWrong(new DaemonEndpoint { TokenFile = PathOf("missing") }, "sweepstaked token create");
            AssertWrong(new DaemonEndpoint { Address = "10.0.0.1:7433", Token = "t" }, "plain text");
        }

        [TestCase("127.0.0.1:1", true)]
        [TestCase("localhost:1", true)]
        [TestCase("[::1]:1", true)]
        [TestCase("10.1.2.3:1", false)]
        [TestCase("localhost.example.org:1", false)]
        public void ThisMachineIsKnown(string address, bool isLoopback)
        {
            Assert.That(new DaemonEndpoint { Address = address }.IsLoopback, Is.EqualTo(isLoopback));
        }

        private static void AssertWrong(DaemonEndpoint endpoint, string advice)
        {
            var wrong = Assert.Throws<SweepstakeException>(() => new DaemonClient(endpoint).Dispose());
            Assert.That(wrong.Message, Does.Contain(advice));
        }

        /// <summary>Checks that the game gets an error message, never connects, and continues.</summary>
        private static void AssertNeverOnline(Game game)
        {
            game.PlayUntil(() => game.Status.LastError.Length > 0, "shown an error");
            game.Play(1000);
            Assert.That(game.Status.Stats.ConnectionCount, Is.EqualTo(0));
        }

        private string PathOf(string name) => Path.Combine(folder, name);

        private sealed class TestAuthority : IDisposable
        {
            private static readonly DateTimeOffset Begin = DateTimeOffset.UtcNow.AddDays(-1);
            private readonly string folder;
            private readonly bool withRsa;
            private readonly X509Certificate2 certificate;

            internal TestAuthority(string folder, string name, bool withRsa)
            {
                this.folder = folder;
                this.withRsa = withRsa;
                CertificateRequest request = Request("CN=" + name, out AsymmetricAlgorithm key);
                using (key)
                {
                    request.CertificateExtensions.Add(new X509BasicConstraintsExtension(true, false, 0, true));
                    certificate = request.CreateSelfSigned(Begin, Begin.AddDays(3));
                }
                File = Path.Combine(folder, name + ".pem");
                System.IO.File.WriteAllText(File, certificate.ExportCertificatePem());
            }

            internal string File { get; }

            internal void Issue(string name, string host = "localhost", IPAddress address = null)
            {
                CertificateRequest request = Request("CN=" + name, out AsymmetricAlgorithm key);
                using (key)
                {
                    var names = new SubjectAlternativeNameBuilder();
                    names.AddDnsName(host);
                    names.AddIpAddress(address ?? DaemonProcess.Host);
                    request.CertificateExtensions.Add(names.Build());
                    using X509Certificate2 issued = request.Create(certificate, Begin, Begin.AddDays(2), Guid.NewGuid().ToByteArray());
                    System.IO.File.WriteAllText(Path.Combine(folder, name + ".pem"), issued.ExportCertificatePem());
                    System.IO.File.WriteAllText(Path.Combine(folder, name + ".key"), key.ExportPkcs8PrivateKeyPem());
                }
            }

            public void Dispose()
            {
                certificate.Dispose();
            }

            private CertificateRequest Request(string name, out AsymmetricAlgorithm key)
            {
                if (withRsa)
                {
                    RSA rsa = RSA.Create(2048);
                    key = rsa;
                    return new CertificateRequest(name, rsa, HashAlgorithmName.SHA256, RSASignaturePadding.Pkcs1);
                }
                ECDsa curve = ECDsa.Create(ECCurve.NamedCurves.nistP256);
                key = curve;
                return new CertificateRequest(name, curve, HashAlgorithmName.SHA256);
            }
        }
    }
}
