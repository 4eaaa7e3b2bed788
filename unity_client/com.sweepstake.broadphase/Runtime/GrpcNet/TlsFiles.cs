#nullable enable
using System;
using System.IO;
using System.Linq;
using System.Net.Http;
using System.Net.Security;
using System.Security.Cryptography;
using System.Security.Cryptography.X509Certificates;

namespace Sweepstake.GrpcNet
{
    /// <summary>TLS files in PEM format. The system selects the TLS version.</summary>
    public sealed class TlsFiles
    {
        /// <summary>Certificate authorities for the daemon's certificate, for example a private one; null for the system's authorities.</summary>
        public string? CaFile { get; set; }
        /// <summary>The game's certificate with its chain, if the daemon requires one; null for none.</summary>
        public string? CertFile { get; set; }
        /// <summary>The private key of the certificate, without a passphrase; only together with <see cref="CertFile"/>.</summary>
        public string? KeyFile { get; set; }

        /// <summary>Configures the handler with these authorities and this certificate.</summary>
        /// <exception cref="SweepstakeException">A file is missing or has the wrong content.</exception>
        public void Configure(HttpClientHandler handler)
        {
            if (!string.IsNullOrEmpty(CaFile))
            {
                X509Certificate2[] authorities = Pem.Certificates(CaFile!);
                handler.ServerCertificateCustomValidationCallback =
                    (request, certificate, chain, errors) => certificate != null && IsSignedBy(authorities, certificate, chain, errors);
            }
            if (string.IsNullOrEmpty(CertFile) != string.IsNullOrEmpty(KeyFile))
                throw DaemonEndpoint.Wrong("A certificate and its key belong together; name both files or neither.");
            if (!string.IsNullOrEmpty(CertFile))
            {
                handler.ClientCertificateOptions = ClientCertificateOption.Manual;
                handler.ClientCertificates.Add(Pem.CertificateWithKey(CertFile!, KeyFile!));
            }
        }

        /// <summary>Whether one of these authorities (and not one of the system's) signed the certificate for the requested host.</summary>
        private static bool IsSignedBy(X509Certificate2[] authorities, X509Certificate2 certificate, X509Chain? sent, SslPolicyErrors errors)
        {
            if ((errors & ~SslPolicyErrors.RemoteCertificateChainErrors) != SslPolicyErrors.None)
                return false;
            using var chain = new X509Chain();
            chain.ChainPolicy.RevocationMode = X509RevocationMode.NoCheck;
            chain.ChainPolicy.VerificationFlags = X509VerificationFlags.AllowUnknownCertificateAuthority;
            chain.ChainPolicy.ExtraStore.AddRange(authorities);
            if (sent != null)
            {
                foreach (X509ChainElement element in sent.ChainElements)
                    chain.ChainPolicy.ExtraStore.Add(element.Certificate);
            }
            if (!chain.Build(certificate))
                return false;
            byte[] root = chain.ChainElements[chain.ChainElements.Count - 1].Certificate.RawData;
            return authorities.Any(authority => authority.RawData.SequenceEqual(root));
        }
    }

    /// <summary>Reads certificates and keys from PEM files, which .NET Standard 2.1 cannot do.</summary>
    internal static class Pem
    {
        internal static X509Certificate2[] Certificates(string path)
        {
            string text = Read(path);
            try
            {
                X509Certificate2[] certificates = Sections(text, "CERTIFICATE").Select(der => new X509Certificate2(der)).ToArray();
                return certificates.Length > 0 ? certificates : throw DaemonEndpoint.Wrong($"{path} does not contain a certificate in PEM format.");
            }
            catch (Exception broken) when (broken is CryptographicException || broken is FormatException)
            {
                throw DaemonEndpoint.Wrong($"{path} contains a broken certificate.", broken);
            }
        }

        internal static X509Certificate2 CertificateWithKey(string certPath, string keyPath)
        {
            X509Certificate2 certificate = Certificates(certPath)[0];
            string text = Read(keyPath);
            try
            {
                using X509Certificate2 whole = WithKey(certificate, text, keyPath);
                // Export the certificate and load it again, because Windows does not accept a key that exists only in memory.
                return new X509Certificate2(whole.Export(X509ContentType.Pkcs12));
            }
            catch (Exception broken) when (broken is CryptographicException || broken is FormatException || broken is ArgumentException)
            {
                throw DaemonEndpoint.Wrong($"{keyPath} is not the key of {certPath}.", broken);
            }
        }

        private static X509Certificate2 WithKey(X509Certificate2 certificate, string text, string path)
        {
            byte[]? pkcs8 = Sections(text, "PRIVATE KEY").FirstOrDefault();
            if (certificate.GetECDsaPublicKey() is ECDsa publicKey)
            {
                publicKey.Dispose();
                using ECDsa key = ECDsa.Create();
                if (pkcs8 != null)
                    key.ImportPkcs8PrivateKey(pkcs8, out _);
                else
                    key.ImportECPrivateKey(Only(text, "EC PRIVATE KEY", path), out _);
                return certificate.CopyWithPrivateKey(key);
            }
            using RSA rsa = RSA.Create();
            if (pkcs8 != null)
                rsa.ImportPkcs8PrivateKey(pkcs8, out _);
            else
                rsa.ImportRSAPrivateKey(Only(text, "RSA PRIVATE KEY", path), out _);
            return certificate.CopyWithPrivateKey(rsa);
        }

        private static byte[] Only(string text, string kind, string path) =>
            Sections(text, kind).FirstOrDefault() ?? throw DaemonEndpoint.Wrong($"{path} does not contain a private key in PEM format without a passphrase.");

        private static System.Collections.Generic.IEnumerable<byte[]> Sections(string text, string kind)
        {
            string begin = $"-----BEGIN {kind}-----";
            string end = $"-----END {kind}-----";
            for (int at = text.IndexOf(begin, StringComparison.Ordinal); at >= 0; at = text.IndexOf(begin, at, StringComparison.Ordinal))
            {
                at += begin.Length;
                int stop = text.IndexOf(end, at, StringComparison.Ordinal);
                if (stop < 0)
                    throw new FormatException("A section of the PEM file has no END line.");
                yield return Convert.FromBase64String(text.Substring(at, stop - at));
            }
        }

        private static string Read(string path)
        {
            try
            {
                return File.ReadAllText(path);
            }
            catch (Exception problem) when (problem is IOException || problem is UnauthorizedAccessException)
            {
                throw DaemonEndpoint.Wrong($"Cannot read {path}; name a PEM file.", problem);
            }
        }
    }
}
