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
    /// <summary>TLS, of the versions that the system allows. The files are PEM.</summary>
    public sealed class TlsFiles
    {
        /// <summary>Authorities of the daemon's certificate, such as one of your own; null: the system's.</summary>
        public string? CaFile { get; set; }
        /// <summary>The game's certificate and its issuers', where the daemon asks for one; null: none.</summary>
        public string? CertFile { get; set; }
        /// <summary>Its private key, without a passphrase; with <see cref="CertFile"/> only.</summary>
        public string? KeyFile { get; set; }

        /// <summary>Makes the handler check the daemon by these authorities and show this certificate.</summary>
        /// <exception cref="SweepstakeException">A file is missing or holds something else.</exception>
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

        /// <summary>Whether one of these authorities, and no other, has signed it, for the host that was asked for.</summary>
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

    /// <summary>Certificates and keys of PEM files, which .NET Standard 2.1 cannot read.</summary>
    internal static class Pem
    {
        internal static X509Certificate2[] Certificates(string path)
        {
            string text = Read(path);
            try
            {
                X509Certificate2[] certificates = Sections(text, "CERTIFICATE").Select(der => new X509Certificate2(der)).ToArray();
                return certificates.Length > 0 ? certificates : throw DaemonEndpoint.Wrong($"{path} holds no certificate in PEM.");
            }
            catch (Exception broken) when (broken is CryptographicException || broken is FormatException)
            {
                throw DaemonEndpoint.Wrong($"{path} holds a broken certificate.", broken);
            }
        }

        internal static X509Certificate2 CertificateWithKey(string certPath, string keyPath)
        {
            X509Certificate2 certificate = Certificates(certPath)[0];
            string text = Read(keyPath);
            try
            {
                using X509Certificate2 whole = WithKey(certificate, text, keyPath);
                // Windows takes no key that is in memory alone.
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
            Sections(text, kind).FirstOrDefault() ?? throw DaemonEndpoint.Wrong($"{path} holds no private key in PEM without a passphrase.");

        private static System.Collections.Generic.IEnumerable<byte[]> Sections(string text, string kind)
        {
            string begin = $"-----BEGIN {kind}-----";
            string end = $"-----END {kind}-----";
            for (int at = text.IndexOf(begin, StringComparison.Ordinal); at >= 0; at = text.IndexOf(begin, at, StringComparison.Ordinal))
            {
                at += begin.Length;
                int stop = text.IndexOf(end, at, StringComparison.Ordinal);
                if (stop < 0)
                    throw new FormatException("A section does not end.");
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
